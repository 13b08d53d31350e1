#!/usr/bin/env python3
"""Writes open_wheel.step, plane_blades.step, filleted_blades.step and covered_wheel.step with Open CASCADE (pip install
"cadquery-ocp<7.9"): three blades fused to a hub, their tips turned: open_wheel.py cylindrical open_wheel.step; open_wheel.py
plane plane_blades.step; open_wheel.py filleted filleted_blades.step, the same with root fillets of 1.2 mm; open_wheel.py
covered covered_wheel.step, whose blades are those of the first, fused to a cover of 2.5 mm, too.

Hub and shroud are arcs about (50, 40), of radius 36, and about (50, 27), of radius 18, in the meridional plane (r, z), mm.
"""
import math
import sys

from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Fuse
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
from OCP.GC import GC_MakeArcOfCircle
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TColgp import TColgp_HArray1OfPnt
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopExp import TopExp
from OCP.TopLoc import TopLoc_Location
from OCP.TopTools import TopTools_IndexedMapOfShape
from OCP.TopoDS import TopoDS
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec

AXIS = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))


def at(r, z, theta=0.0):
    return gp_Pnt(r * math.cos(theta), r * math.sin(theta), z)


def hub(m):
    return 50 - 36 * math.cos(m * math.pi / 2), 40 - 36 * math.sin(m * math.pi / 2)


def shroud(m):
    return 50 - 18 * math.cos(m * math.pi / 2), 27 - 18 * math.sin(m * math.pi / 2)


def outside(m):
    """Of the cover."""
    return 50 - 15.5 * math.cos(m * math.pi / 2), 27 - 15.5 * math.sin(m * math.pi / 2)


def arc(curve, theta=0.0):
    ends = [at(*curve(m), theta) for m in (0, 0.5, 1)]
    return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(*ends).Value()).Edge()


def line(a, b):
    return BRepBuilderAPI_MakeEdge(at(*a), at(*b)).Edge()


def turned(edges):
    wire = BRepBuilderAPI_MakeWire()
    for edge in edges:
        wire.Add(edge)
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), AXIS).Shape()


def cylindrical():
    """A cylindrical blade of 1.6 mm from r = 40 mm to beyond the rim, through hub and shroud."""

    def place(r, side):
        theta = 0.7 * (r - 33) / 17
        return at(r, 1, theta + side * 0.8 / r)

    def flank(side):
        radii = [40, 43, 47, 51, 56]
        array = TColgp_HArray1OfPnt(1, len(radii))
        for i, r in enumerate(radii):
            array.SetValue(i + 1, place(r, side))
        curve = GeomAPI_Interpolate(array, False, 1e-9)
        curve.Perform()
        return BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()

    wire = BRepBuilderAPI_MakeWire()
    ends = [BRepBuilderAPI_MakeEdge(place(r, 1), place(r, -1)).Edge() for r in (40, 56)]
    for edge in (flank(1), ends[1], flank(-1), ends[0]):
        wire.Add(edge)
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), gp_Vec(0, 0, 30)).Shape()


def plane():
    """A tapered blade with plane sides from x = 40 mm to beyond the rim, and from 0.6 mm below the hub's edge to beyond the
    shroud: its trailing edge, turned with the rim, goes on below that edge."""
    loft = BRepOffsetAPI_ThruSections(True, True, 1e-6)
    for z, pressure, suction in ((3.4, -1.4, 1.2), (31, -0.5, 1.0)):
        corners = BRepBuilderAPI_MakePolygon()
        for x, y in ((40, pressure), (56, pressure - 2), (56, suction - 2), (40, suction)):
            corners.Add(gp_Pnt(x, y, z))
        corners.Close()
        loft.AddWire(corners.Wire())
    return loft.Shape()


def filleted(body):
    """With fillets where blades stand on the hub, which goes on past the rim."""

    def is_root(edge):
        curve = BRepAdaptor_Curve(edge)
        first, last = curve.FirstParameter(), curve.LastParameter()
        for share in (0.13, 0.5, 0.87):
            p = curve.Value(first + (last - first) * share)
            r, z = math.hypot(p.X(), p.Y()), p.Z()
            on_hub = abs(math.hypot(r - 50, z - 40) - 36) < 1e-3 and 20 < r <= 50 or abs(z - 4) < 1e-3 and r < 59.9
            if not on_hub or abs(r - 50) < 1e-4:
                return False
        return True

    edges = TopTools_IndexedMapOfShape()
    TopExp.MapShapes_s(body, TopAbs_EDGE, edges)
    fillet = BRepFilletAPI_MakeFillet(body)
    for edge in (TopoDS.Edge_s(edges.FindKey(k)) for k in range(1, edges.Extent() + 1)):
        if is_root(edge):
            fillet.Add(1.2, edge)
    return fillet.Shape()


def main(kind, path):
    rim = [line((50, 4), (60, 4)), line((60, 4), (60, 0)), line((60, 0), (5, 0))]
    rim = rim if kind == "filleted" else [line((50, 4), (50, 0)), line((50, 0), (5, 0))]
    body = turned([arc(hub), *rim, line((5, 0), (5, 40)), line((5, 40), (14, 40))])
    tip, top = (outside, 34.5) if kind == "covered" else (shroud, 32)
    # What the wheel is turned to: the shroud, the rim, and a cylinder before the shroud.
    envelope = turned(
        [arc(tip), line(tip(1), (50, 0)), line((50, 0), (5, 0)), line((5, 0), (5, 40)), line((5, 40), (top, 40)), line((top, 40), (top, 27))]
    )
    if kind == "covered":
        body = BRepAlgoAPI_Fuse(body, turned([arc(shroud), line((50, 9), (50, 11.5)), arc(outside), line((34.5, 27), (32, 27))])).Shape()
    for k in range(3):
        turn = gp_Trsf()
        turn.SetRotation(AXIS, 2 * math.pi * k / 3)
        blade = plane() if kind in ("plane", "filleted") else cylindrical()
        if kind == "covered":
            blade = BRepAlgoAPI_Common(blade, envelope).Shape()
        body = BRepAlgoAPI_Fuse(body, blade.Moved(TopLoc_Location(turn))).Shape()
    if kind == "filleted":
        body = filleted(body)
    if kind != "covered":
        body = BRepAlgoAPI_Common(body, envelope).Shape()
    writer = STEPControl_Writer()
    writer.Transfer(body, STEPControl_AsIs)
    assert writer.Write(path) == IFSelect_RetDone


main(*sys.argv[1:])
