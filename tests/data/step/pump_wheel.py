#!/usr/bin/env python3
"""Writes pump_wheel.step, pump_bodies.step and pump_covered.step with Open CASCADE (pip install "cadquery-ocp<7.9"): a pump wheel
with five plane blades, whose hub is drawn in pieces: pump_wheel.py one pump_wheel.step; pump_wheel.py bodies
pump_bodies.step; pump_wheel.py covered pump_covered.step, whose blades go on into the hub, through a cover of 4 mm, and past
the rim of both.

Its hub is a cylinder of radius 18 down to z = 40, a quarter of a torus about (48, 40) of radius 30, and the disc z = 10 to
the rim at 100; its shroud is the cone from (45, 44) to (100, 22), in the meridional plane (r, z), mm. The blades are 5 mm
thick between concentric arcs about (CENTRE, 0), with a flat leading edge.
"""
import math
import sys

from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
from OCP.GC import GC_MakeArcOfCircle
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TopLoc import TopLoc_Location
from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec

AXIS = gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))
CENTRE, RADIUS, THICKNESS, BLADES = 60.0, 58.0, 5.0, 5


def line(a, b):
    return BRepBuilderAPI_MakeEdge(gp_Pnt(a[0], a[1], a[2]), gp_Pnt(b[0], b[1], b[2])).Edge()


def arc(a, middle, b):
    return BRepBuilderAPI_MakeEdge(GC_MakeArcOfCircle(gp_Pnt(*a), gp_Pnt(*middle), gp_Pnt(*b)).Value()).Edge()


def face(edges):
    wire = BRepBuilderAPI_MakeWire()
    for edge in edges:
        wire.Add(edge)
    return BRepBuilderAPI_MakeFace(wire.Wire()).Face()


def turned(points, rounded=None):
    """The body of revolution inside of (r, z) points; the side after number `rounded` is an arc about (48, 40)."""
    edges = []
    for k, (a, b) in enumerate(zip(points, points[1:] + points[:1])):
        a, b = (a[0], 0, a[1]), (b[0], 0, b[1])
        half = 30 * math.sqrt(0.5)
        edges.append(arc(a, (48 - half, 0, 40 - half), b) if k == rounded else line(a, b))
    return BRepPrimAPI_MakeRevol(face(edges), AXIS).Shape()


def blade(low):
    """Between arcs about (CENTRE, 0), from the height `low` to above the shroud and from r = 50 to past the rim."""

    def at(radius, angle, z=low):
        return (CENTRE + radius * math.cos(angle), radius * math.sin(angle), z)

    # Where the middle arc has the radius of the leading edge, and well past that of the rim.
    def where(r):
        return math.acos((r * r - CENTRE * CENTRE - RADIUS * RADIUS) / (2 * CENTRE * RADIUS))

    inner, outer = RADIUS - THICKNESS / 2, RADIUS + THICKNESS / 2
    a, b = where(50), where(108)
    edges = [
        arc(at(inner, a), at(inner, (a + b) / 2), at(inner, b)),
        line(at(inner, b), at(outer, b)),
        arc(at(outer, b), at(outer, (a + b) / 2), at(outer, a)),
        line(at(outer, a), at(inner, a)),
    ]
    return BRepPrimAPI_MakePrism(face(edges), gp_Vec(0, 0, 60 - low)).Shape()


def main(kind, path):
    hub = turned([(18, 70), (18, 40), (48, 10), (100, 10), (100, 0), (0, 0), (0, 70)], rounded=1)
    # What the blades are turned to: the shroud, the rim, and a cylinder before the shroud.
    envelope = turned([(45, 44), (100, 22), (100, -1), (0, -1), (0, 80), (45, 80)])
    blades = []
    for k in range(BLADES):
        turn = gp_Trsf()
        turn.SetRotation(AXIS, 2 * math.pi * k / BLADES)
        blades.append(blade(5).Moved(TopLoc_Location(turn)))
    writer = STEPControl_Writer()
    if kind == "one":
        for one in blades:
            hub = BRepAlgoAPI_Fuse(hub, one).Shape()
        writer.Transfer(BRepAlgoAPI_Common(hub, envelope).Shape(), STEPControl_AsIs)
    elif kind == "covered":
        for body in [hub, turned([(45, 44), (100, 22), (100, 26), (45, 48)]), *blades]:
            writer.Transfer(body, STEPControl_AsIs)
    else:
        writer.Transfer(hub, STEPControl_AsIs)
        for one in blades:
            writer.Transfer(BRepAlgoAPI_Cut(BRepAlgoAPI_Common(one, envelope).Shape(), hub).Shape(), STEPControl_AsIs)
    assert writer.Write(path) == IFSelect_RetDone


main(*sys.argv[1:])
