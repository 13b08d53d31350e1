#!/usr/bin/env python3
"""Writes nose_blade.step with Open CASCADE (pip install "cadquery-ocp<7.9"): a blade 40 mm long and 2 mm thick, whose nose
is a face of its own, half an ellipse across and straight from foot to tip; its tip is cut round, higher at the nose.
"""
import math
import sys

from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer
from OCP.TColgp import TColgp_HArray1OfPnt
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt


def spline(points):
    array = TColgp_HArray1OfPnt(1, len(points))
    for k, p in enumerate(points):
        array.SetValue(k + 1, gp_Pnt(*p))
    curve = GeomAPI_Interpolate(array, False, 1e-9)
    curve.Perform()
    return BRepBuilderAPI_MakeEdge(curve.Curve()).Edge()


def section(z):
    """In a plane: the sides bend, and the nose is half an ellipse 4 mm long."""

    def at(x, y):
        return x, y + 0.004 * (1 + z / 60) * x * x, z

    side = {k: [at(4 + 36 * i / 12, k) for i in range(13)] for k in (1, -1)}
    nose = [at(4 - 4 * math.sin(a), math.cos(a)) for a in (math.pi * i / 16 for i in range(17))]
    wire = BRepBuilderAPI_MakeWire()
    tail = BRepBuilderAPI_MakeEdge(gp_Pnt(*side[-1][-1]), gp_Pnt(*side[1][-1])).Edge()
    for edge in (spline(side[1][::-1]), spline(nose), spline(side[-1]), tail):
        wire.Add(edge)
    return wire.Wire()


def main(path):
    loft = BRepOffsetAPI_ThruSections(True, False, 1e-6)
    for z in (0, 13, 26, 40):
        loft.AddWire(section(z))
    round_tip = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, -20, 50), gp_Dir(0, 1, 0)), 25, 60).Shape()
    writer = STEPControl_Writer()
    writer.Transfer(BRepAlgoAPI_Cut(loft.Shape(), round_tip).Shape(), STEPControl_AsIs)
    assert writer.Write(path) == IFSelect_RetDone


main(*sys.argv[1:])
