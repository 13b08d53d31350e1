#!/usr/bin/env python3
"""Writes paddle_wheel.step, paddle_foot.step, paddle_corner.step, paddle_splines.step, paddle_fillets.stl and pump_eye.step
with Open CASCADE (pip install "cadquery-ocp<7.9").

paddle_wheel.py paddles paddle_wheel.step: three radial paddles of 3 mm on a disc, which begin in its boss of radius 15 mm; the
boss ends at z = 16 mm, as the paddles do, or, with `tall`, at z = 22 mm.

paddle_wheel.py foot paddle_foot.step: the same paddles and boss, with a rounded corner of 4 mm at the foot of the boss.

paddle_wheel.py corner paddle_corner.step: three vanes, arcs of 45.4 and 48 mm about (0, 43), from r = 22 mm on, which
stand on the disc and on a cone ahead of it: between them the hub has a corner of 30 degrees at r = 24 mm.

paddle_wheel.py splines paddle_splines.step: the paddles and boss of paddle_wheel.step, with B-splines as their surfaces, and a
rounded top of the boss that meets the axis, which is none.

paddle_wheel.py fillets paddle_fillets.stl: the same paddles, which begin at x = 25 mm, free of the boss, with fillets of 1 mm
at their foot, as triangles within 0.01 mm.

paddle_wheel.py eye pump_eye.step: a covered wheel whose three blades divide the inside of its cover and cross the wall of
its eye, with five vanes on the back of its hub, a nut, and four small blocks beside it.
"""
import math
import sys

from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Fuse
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeWire,
    BRepBuilderAPI_NurbsConvert,
)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeRevol
from OCP.GC import GC_MakeArcOfCircle
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.StlAPI import StlAPI_Writer
from OCP.TopAbs import TopAbs_EDGE
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec

AXIS = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))


def turned(*outline, arcs={}):
    wire = BRepBuilderAPI_MakeWire()
    for k, ((r, z), (s, w)) in enumerate(zip(outline, outline[1:] + outline[:1])):
        a, b = gp_Pnt(r, 0, z), gp_Pnt(s, 0, w)
        if k in arcs:
            x, y = arcs[k]
            wire.Add(BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(a, gp_Pnt(x, 0, y), b).Value()).Edge())
        else:
            wire.Add(BRepBuilderAPI_MakeEdge(a, b).Edge())
    return BRepPrimAPI_MakeRevol(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), AXIS).Shape()


def fused(body, blade, envelope, count=3):
    for k in range(count):
        turn = gp_Trsf()
        turn.SetRotation(AXIS, 2 * math.pi * k / count)
        body = BRepAlgoAPI_Fuse(body, BRepAlgoAPI_Common(blade, envelope).Shape().Moved(TopLoc_Location(turn))).Shape()
    return body


def filleted(body, radius):
    """With fillets along all edges on z = 4 mm that are between the boss and the rim."""
    fillet = BRepFilletAPI_MakeFillet(body)
    edges = TopExp_Explorer(body, TopAbs_EDGE)
    done = []
    while edges.More():
        edge = TopoDS.Edge_s(edges.Current())
        curve = BRepAdaptor_Curve(edge)
        first, last = curve.FirstParameter(), curve.LastParameter()
        places = [curve.Value(first + (last - first) * x) for x in (0.1, 0.5, 0.9)]
        if all(abs(p.Z() - 4) < 1e-3 and 20 < math.hypot(p.X(), p.Y()) < 65.9 for p in places):
            if not any(edge.IsSame(other) for other in done):
                done.append(edge)
                fillet.Add(radius, edge)
        edges.Next()
    fillet.Build()
    return fillet.Shape()


def main(kind, path):
    if kind == "fillets":
        disc = turned((5, 0), (66, 0), (66, 4), (15, 4), (15, 16), (5, 16))
        envelope = turned((5, -1), (64, -1), (64, 40), (5, 40))
        body = fused(disc, BRepPrimAPI_MakeBox(gp_Pnt(25, -1.5, 2), gp_Pnt(63, 1.5, 16)).Shape(), envelope)
        rim = turned((5, -1), (60, -1), (60, 40), (5, 40))
        body = BRepAlgoAPI_Common(filleted(body, 1.0), rim).Shape()
        BRepMesh_IncrementalMesh(body, 0.01, False, 0.2, True)
        stl = StlAPI_Writer()
        stl.ASCIIMode = False
        assert stl.Write(body, path)
        return
    if kind == "eye":
        hub = turned((10, -6), (70, -6), (70, 4), (24, 7), (16, 14), (10, 20))
        cover = turned((30, 22), (70, 14), (70, 17), (36, 25), (36, 34), (30, 34))
        envelope = turned((9, -7), (70, -7), (70, 15.5), (33, 23), (33, 23.4), (9, 23.4))
        body = fused(hub, BRepPrimAPI_MakeBox(gp_Pnt(26, -1.5, 2), gp_Pnt(74, 1.5, 24)).Shape(), envelope)
        back = turned((20, -10), (70, -10), (70, 0), (20, 0))
        body = fused(body, BRepPrimAPI_MakeBox(gp_Pnt(18, -1, -10), gp_Pnt(74, 1, -5)).Shape(), back, 5)
        bodies = [BRepAlgoAPI_Fuse(body, cover).Shape(), turned((10, 20.5), (15, 20.5), (15, 27), (10, 27))]
        bodies += [BRepPrimAPI_MakeBox(gp_Pnt(80 + 4 * k, 0, 0), gp_Pnt(82 + 4 * k, 6, 1)).Shape() for k in range(4)]
    elif kind == "foot":
        middle = 4 - 4 * math.sqrt(0.5)
        outline = (5, 0), (60, 0), (60, 4), (19, 4), (15, 8), (15, 16), (5, 16)
        disc = turned(*outline, arcs={3: (15 + middle, 4 + middle)})
        envelope = turned((5, -1), (60, -1), (60, 40), (5, 40))
        bodies = [fused(disc, BRepPrimAPI_MakeBox(gp_Pnt(12, -1.5, 2), gp_Pnt(62, 1.5, 16)).Shape(), envelope)]
    elif kind == "splines":
        disc = turned((5, 0), (60, 0), (60, 4), (15, 4), (15, 16), (5, 16))
        envelope = turned((5, -1), (60, -1), (60, 40), (5, 40))
        body = fused(disc, BRepPrimAPI_MakeBox(gp_Pnt(12, -1.5, 2), gp_Pnt(62, 1.5, 16)).Shape(), envelope)
        body = BRepBuilderAPI_NurbsConvert(body, True).Shape()
        bodies = [BRepAlgoAPI_Fuse(body, turned((0, 0), (5, 0), (5, 16), (0, 18), arcs={2: (3, 17.4)})).Shape()]
    elif kind == "corner":
        disc = turned((8, 0), (60, 0), (60, 4), (24, 6), (15, 12), (12, 18), (8, 18))
        place = gp_Trsf()
        place.SetTranslation(gp_Vec(0, 43, 0))
        ring = turned((45.4, 2), (48, 2), (48, 20), (45.4, 20)).Moved(TopLoc_Location(place))
        vane = BRepAlgoAPI_Common(ring, BRepPrimAPI_MakeBox(gp_Pnt(0, -80, 0), gp_Pnt(80, 80, 40)).Shape()).Shape()
        bodies = [fused(disc, vane, turned((22, -1), (60, -1), (60, 16), (22, 16)))]
    else:
        top = 22 if kind == "tall" else 16
        disc = turned((5, 0), (60, 0), (60, 4), (15, 4), (15, top), (5, top))
        envelope = turned((5, -1), (60, -1), (60, 40), (5, 40))
        bodies = [fused(disc, BRepPrimAPI_MakeBox(gp_Pnt(12, -1.5, 2), gp_Pnt(62, 1.5, 16)).Shape(), envelope)]
    writer = STEPControl_Writer()
    for body in bodies:
        writer.Transfer(body, STEPControl_AsIs)
    assert writer.Write(path) == IFSelect_RetDone


main(*sys.argv[1:])
