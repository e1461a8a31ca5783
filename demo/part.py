"""Writes scenes/part.stl, the small mesh of the examples: an angle bracket, 40 x 20 x 30, walls 4 thick.

Run as `python3 demo/part.py > scenes/part.stl`.
"""

# The profile in x and z, counter-clockwise seen from -y, as a fan around its first corner.
PROFILE = [(0, 0), (40, 0), (40, 4), (4, 4), (4, 30), (0, 30)]
DEPTH = 20


def triangles():
    """The faces of the prism over the profile, counter-clockwise seen from outside."""
    near = [(x, 0, z) for x, z in PROFILE]
    far = [(x, DEPTH, z) for x, z in PROFILE]
    for k in range(1, len(PROFILE) - 1):
        yield near[0], near[k], near[k + 1]
        yield far[0], far[k + 1], far[k]
    for k in range(len(PROFILE)):
        a, b = k, (k + 1) % len(PROFILE)
        yield near[a], far[a], far[b]
        yield near[a], far[b], near[b]


def normal(a, b, c):
    """The unit normal of a triangle."""
    u, v = [[q - p for p, q in zip(a, corner, strict=False)] for corner in (b, c)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    length = sum(x * x for x in n) ** 0.5
    return [x / length + 0 for x in n]


print("solid part")
for corners in triangles():
    print("  facet normal", *(f"{x:g}" for x in normal(*corners)))
    print("    outer loop")
    for corner in corners:
        print("      vertex", *corner)
    print("    endloop")
    print("  endfacet")
print("endsolid part")
