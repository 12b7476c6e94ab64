"""The body: its measurements, its shape and its pictures; no web, no HTML.

Units are SI: metres, kilograms. Axes are glTF's: +Y up, the person faces +Z and has
their left at +X; soles at Y = 0, centred at X = 0. Vertices are arrays of shape (V, 3),
batches of bodies of shape (B, V, 3), triangles of shape (F, 3).
"""
