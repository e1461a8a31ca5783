"""Meshes and scenes of other packages. Stand-ins with their documented attributes are tested always; objects of the
packages themselves only if these are installed."""

import numpy as np
import pytest
from shotline import Mesh, Scene

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], float)
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
# The cube [-1, 1]^3 as quads.
CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


class Bag:
    def __init__(self, **attributes):
        vars(self).update(attributes)


def poly_data(points, cells, strips=(), lines=0, verts=0, **more):
    """A stand-in with the documented attributes of pyvista.PolyData."""
    faces = np.concatenate([np.zeros(0, int), *([len(cell), *cell] for cell in cells)])
    return Bag(points=points, faces=faces, strips=np.array(strips, int), n_lines=lines, n_verts=verts, **more)


def through(node):
    return Scene(node).crossings([-5, 0.2, 0.3], [1, 0, 0]).t.tolist()


def test_quads_of_meshio_are_triangulated_and_lines_left_out():
    blocks = [("vertex", [[0]]), ("line", [[0, 1], [1, 2]]), ("quad", QUADS[:3]), ("quad", QUADS[3:])]
    source = Bag(points=CUBE, cells_dict={}, cells=[Bag(type=kind, data=np.array(data)) for kind, data in blocks])
    with pytest.warns(UserWarning, match="1 point, 2 lines left out: without an area") as caught:
        mesh = Mesh(source)
    assert caught[0].filename == __file__
    assert mesh.is_closed and len(mesh.faces) == 12 and through(mesh) == [4, 6]
    assert Mesh(Bag(points=CORNERS, cells_dict={"triangle": FACES})).faces.tolist() == FACES.tolist()


@pytest.mark.parametrize("kind", ["tetra", "hexahedron", "triangle6", "polyhedron"])
def test_volume_meshes_and_curved_cells_of_meshio_are_refused(kind):
    source = Bag(points=CORNERS, cells_dict={"triangle": FACES, kind: np.zeros((3, 4), int)})
    with pytest.raises(ValueError, match=f"not triangles, quads or polygons: 3 of {kind}; extract its surface"):
        Mesh(source)


def test_errors_for_meshes_without_faces_list_their_cells():
    with pytest.raises(ValueError, match="no triangles, but 2 lines"):
        Mesh(Bag(points=CORNERS, cells_dict={"line": np.array([[0, 1], [1, 2]])}))
    with pytest.raises(ValueError, match="no faces, but 3 points"):
        Mesh(poly_data(CORNERS, [], verts=3))
    with pytest.raises(ValueError, match=r"face 1 is \[0, 1, 2, 9\], but vertices are numbered from 0 to 3"):
        Mesh(Bag(points=CORNERS, cells_dict={"quad": np.array([[0, 1, 2, 3], [0, 1, 2, 9]])}))


@pytest.mark.parametrize("turned", range(4))
def test_concave_quads_are_triangulated_inside_their_outline(turned):
    """An arrow head, listed from each of its corners: its area is correct, and the notch has no hit."""
    points = np.array([(0, 0, 0), (2, -2, 0), (0, 2, 0), (-2, -2, 0)], float)
    mesh = Mesh(Bag(points=points, cells_dict={"quad": np.roll([[0, 1, 2, 3]], turned, axis=1)}))
    a, b, c = (points[mesh.faces[:, i]] for i in range(3))
    assert np.cross(b - a, c - a)[:, 2].tolist() == [4, 4]
    assert Scene(mesh).count([[0, -0.5, -1], [0, 0.5, -1], [1, -0.5, -1]], [0, 0, 1]).tolist() == [0, 1, 1]


def test_faces_of_pyvista_are_read():
    assert Mesh(poly_data(CORNERS, FACES)).faces.tolist() == FACES.tolist()
    mixed = poly_data(CUBE, [*QUADS[:4], (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)])
    mesh = Mesh(mixed)
    assert mesh.is_closed and len(mesh.faces) == 12 and through(mesh) == [4, 6]
    # Every second triangle of a strip has its orientation reversed.
    strips = [4, 0, 1, 2, 3, 4, 4, 6, 5, 7, 4, 0, 4, 1, 5, 4, 2, 3, 6, 7, 4, 0, 2, 4, 6, 4, 1, 5, 3, 7]
    mesh = Mesh(poly_data(CUBE, [], strips))
    assert mesh.is_closed and len(mesh.faces) == 12 and through(mesh) == [4, 6]
    with pytest.warns(UserWarning, match="2 lines, 5 points left out"):
        assert len(Mesh(poly_data(CORNERS, FACES, lines=2, verts=5)).faces) == 4


# A prism over an L, with faces of six and of four corners.
ELL = np.array([(x, y, z) for z in (0, 1) for x, y in ((0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2))], float)
ELL_FACES = [
    (5, 4, 3, 2, 1, 0),
    (6, 7, 8, 9, 10, 11),
    *((i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6) for i in range(6)),
]


def test_polygons_are_triangulated_inside_their_outline():
    of_meshio = [Bag(type="polygon", data=np.array(ELL_FACES[:2])), Bag(type="quad", data=np.array(ELL_FACES[2:]))]
    for mesh in (
        Mesh(ELL, ELL_FACES),
        Mesh(poly_data(ELL, ELL_FACES)),
        Mesh(Bag(points=ELL, cells_dict={}, cells=of_meshio)),
    ):
        assert mesh.is_closed and mesh.polygons.tolist() == [0] * 4 + [1] * 4 + [
            i for i in range(2, 8) for _ in "ab"
        ]
        # No triangle covers the notch; a fan from the first corner would.
        assert Scene(mesh).count([[1.5, 1.5, -1], [0.5, 1.5, -1]], [0, 0, 1]).tolist() == [0, 2]
    assert Mesh(ELL, np.array(ELL_FACES[2:])).polygons.tolist() == [i for i in range(6) for _ in "ab"]


def test_faces_that_are_not_polygons_are_refused_or_dropped():
    with pytest.raises(ValueError, match=r"not \(1, 2\)"):
        Mesh(ELL, [(0, 1, 2), (0, 1)])
    with pytest.raises(TypeError, match="so integers, not float64"):
        Mesh(ELL, [(0, 1, 2.5), (0, 1, 2, 3)])
    with pytest.raises(ValueError, match=r"face 1 is \[0, 1, 2, 12\]"):
        Mesh(ELL, [(0, 1, 2), (0, 1, 2, 12)])
    with pytest.warns(UserWarning, match="1 polygon that crosses itself"):
        Mesh(ELL, [(0, 2, 1, 5)])


def test_grids_and_files_are_refused_with_a_remedy():
    grid = Bag(points=CUBE, cells=0, cells_dict={}, extract_surface=None)
    with pytest.raises(ValueError, match=r"a Bag holds more than a surface: take its extract_surface\(\)"):
        Mesh(grid)
    with pytest.raises(TypeError, match=r"shotline.load\('part.stl'\) reads one"):
        Mesh("part.stl")
    with pytest.raises(TypeError, match=r"not of Bag: wrap a mesh of another package, as in Scene\(Mesh\(mesh\)\)"):
        Scene(Bag(vertices=CUBE, faces=FACES))


class Graph:
    """A stand-in with the documented attributes of the graph of a trimesh scene."""

    def __init__(self, **nodes):
        self.nodes, self.nodes_geometry = nodes, list(nodes)

    def __getitem__(self, node):
        return self.nodes[node]


def stand_in_scene():
    move, mirror = np.eye(4), np.diag([-1.0, 1, 1, 1])
    move[0, 3], mirror[0, 3] = 10, -10
    tetra, curve = Bag(vertices=CORNERS, faces=FACES), Bag(vertices=CORNERS)
    graph = Graph(a=(np.eye(4), "tetra"), b=(move, "tetra"), c=(mirror, "tetra"), d=(move, "curve"))
    return Bag(geometry={"tetra": tetra, "curve": curve}, graph=graph)


def test_nodes_of_a_trimesh_scene_become_objects_of_their_names():
    with pytest.warns(UserWarning, match="'d' is left out: a Bag has no faces"):
        scene = Scene(stand_in_scene())
    assert scene.object_names == ["a", "b", "c"] and scene.stats["leaves"] == 1
    o = [[0.1, 0.2, -1], [10.1, 0.2, -1], [-10.1, 0.2, -1]]
    assert scene.closest(o, [0, 0, 1]).object.tolist() == [0, 1, 2]
    assert scene.contains(np.array(o) + [0, 0, 1.1]).all()


def test_a_mesh_of_a_trimesh_scene_joins_all_its_meshes():
    with pytest.warns(UserWarning, match="'d' is left out"):
        mesh = Mesh(stand_in_scene())
    assert mesh.is_closed and len(mesh.faces) == 12
    measures = Scene(mesh).measure()
    assert measures.volume[0] == pytest.approx(0.5, rel=1e-12) and measures.exact[0]
    with pytest.raises(ValueError, match="holds no mesh"):
        Mesh(Bag(geometry={}, graph=Graph()))


def test_objects_of_trimesh():
    trimesh = pytest.importorskip("trimesh", reason="trimesh is not installed")
    box = trimesh.creation.box()
    scene = trimesh.Scene()
    scene.add_geometry(box, node_name="here", geom_name="box")
    scene.add_geometry(
        box, node_name="there", geom_name="box", transform=trimesh.transformations.translation_matrix([5, 0, 0])
    )
    assert len(Mesh(trimesh.Scene([box])).faces) == 12
    both = Scene(scene)
    assert sorted(both.object_names) == ["here", "there"]
    assert sorted(both.crossings([-5, 0.1, 0.2], [1, 0, 0]).t.tolist()) == [4.5, 5.5, 9.5, 10.5]


def test_objects_of_meshio():
    meshio = pytest.importorskip("meshio", reason="meshio is not installed")
    cells = [("line", np.array([[0, 1]])), ("triangle", FACES)]
    with pytest.warns(UserWarning, match="1 line left out"):
        assert len(Mesh(meshio.Mesh(CORNERS, cells)).faces) == 4
    assert through(Mesh(meshio.Mesh(CUBE, [("quad", QUADS)]))) == [4, 6]
    with pytest.raises(ValueError, match="1 of tetra"):
        Mesh(meshio.Mesh(CORNERS, [("tetra", np.array([[0, 1, 2, 3]]))]))


def test_objects_of_pyvista():
    pyvista = pytest.importorskip("pyvista", reason="pyvista is not installed")
    cube = pyvista.Cube(x_length=2, y_length=2, z_length=2)
    for source in (cube, cube.triangulate(), pyvista.Cube(clean=False).scale(2.0)):
        assert len(Mesh(source).faces) == 12 and through(Mesh(source)) == [4, 6]
    ball = pyvista.Sphere(radius=2, theta_resolution=20, phi_resolution=20)
    assert Mesh(ball).is_closed and Mesh(ball.strip()).is_closed
    assert len(Mesh(ball.strip()).faces) == len(Mesh(ball).faces)
    prism = pyvista.Cylinder(resolution=7)
    assert Mesh(prism.clean()).is_closed
    with pytest.raises(ValueError, match="extract_surface"):
        Mesh(pyvista.ImageData(dimensions=(3, 3, 3)).cast_to_unstructured_grid())
