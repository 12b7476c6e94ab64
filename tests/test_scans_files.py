import numpy as np
import pytest
import trimesh

from model.training.scans_files import ScanError, read_scan

POINTS = np.array([[0, 0, 0], [1.5, 0, 0], [0, 2.25, 0], [0, 0, -3]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


def obj(faces="f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n", head=""):
    return (head + "".join(f"v {x:g} {y:g} {z:g}\n" for x, y, z in POINTS) + faces).encode()


def ply(form, corners="uchar int", points=POINTS, faces=FACES):
    """A PLY file with more in it than is needed."""
    header = (
        f"ply\nformat {form} 1.0\ncomment made\nelement vertex {len(POINTS)}\nproperty double x\n"
        "property double y\nproperty double z\nproperty uchar red\n"
        f"element face {len(FACES)}\nproperty list {corners} vertex_indices\nend_header\n"
    ).encode()
    if form == "ascii":
        rows = [f"{x} {y} {z} 7" for x, y, z in points] + [
            " ".join(map(str, [len(face), *face])) for face in faces
        ]
        return header + ("\n".join(rows) + "\n").encode()
    order = "<" if "little" in form else ">"
    count, kind = ({"uchar": "u1", "int": "i4", "ushort": "u2"}[word] for word in corners.split())
    vertices = b"".join(
        np.array(point, order + "f8").tobytes() + b"\7" for point in np.asarray(points, float)
    )
    return (
        header
        + vertices
        + b"".join(
            np.array([len(face)], order + count).tobytes() + np.array(face, order + kind).tobytes()
            for face in faces
        )
    )


FORMS = ["ascii", "binary_little_endian", "binary_big_endian"]


def check(mesh):
    assert np.array_equal(mesh.vertices, POINTS)
    assert np.array_equal(mesh.faces, FACES)


@pytest.mark.parametrize(
    "content",
    [
        obj(),
        obj(head="# Spring\no body\n\n").replace(b"\n", b"\r\n"),
        obj("f 1/1/1 3/2/1 2/3/1\nf 1//4 2//4 4//4\nf 2/1 3/1 4/1\nf 1 4 3"),
        obj("f -4 -2 -3\nf -4 -3 -1\nf -3 -2 -1\nf -4 -1 -2\n"),
        obj().replace(b"0 0 -3", b"0 0 -3 0.5 0.5 0.5").replace(b"v 1.5", b"v  1.5"),
    ],
    ids=["plain", "comments", "textures", "backwards", "colours"],
)
def test_obj_is_read(content):
    check(read_scan("a.obj", content))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("corners", ["uchar int", "int int", "uchar ushort"])
def test_ply_is_read(form, corners):
    check(read_scan("a.PLY", ply(form, corners)))


def test_another_writer_of_ply_is_understood():
    mesh = trimesh.creation.icosphere(1)
    for encoding in ("ascii", "binary"):
        read = read_scan("a.ply", mesh.export(file_type="ply", encoding=encoding))
        assert np.abs(read.vertices - mesh.vertices).max() < 1e-6
        assert np.array_equal(read.faces, mesh.faces)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (obj().replace(b"v 1.5 0 0", b"v 1.5 nan 0"), "a.obj, line 2: not finite: '1.5 nan 0'"),
        (obj().replace(b"v 1.5 0 0", b"v 1e999 0 0"), "a.obj, line 2: not finite"),
        (obj().replace(b"v 1.5 0 0", b"v 1.5 x 0"), "a.obj, line 2: not a number: '1.5 x 0'"),
        (obj().replace(b"v 1.5 0 0", b"v 1.5 0"), "a.obj, line 2: 2 coordinates, not 3"),
        (obj("f 1 3 2\nf 1 2 4 3\n"), "a.obj, line 6: a face of 4 corners, not a triangle"),
        (obj("f 1 3 2\nf 1 2\n"), "a.obj, line 6: a face of 2 corners, not a triangle"),
        (obj("f 1 3 2 4\nf 1 2\n"), "a.obj, line 5: a face of 4 corners, not a triangle"),
        (obj("f 1 3 2\nf 1 b 3\n"), "a.obj, line 6: no face: '1 b 3'"),
        (obj("f 1 3 2\nf 1 2 5\n"), "a.obj, line 6: there are 4 vertices, this face has 'f 1 2 5'"),
        (obj("f 1 3 2\nf 0 1 2\n"), "a.obj, line 6: there are 4 vertices"),
        (obj("f 1 3 2\nf -5 1 2\n"), "a.obj, line 6: there are 4 vertices"),
        (obj(""), "a.obj: no mesh, 4 vertices and 0 faces"),
        (b"", "a.obj: no mesh, 0 vertices and 0 faces"),
        (b"\0\xff\1", "a.obj: no mesh"),
    ],
)
def test_obj_that_is_wrong_is_refused_with_its_line(content, said):
    with pytest.raises(ScanError) as refused:
        read_scan("a.obj", content)
    assert str(refused.value).startswith(said)


QUAD = [[0, 2, 1], [0, 1, 3, 2], [1, 2, 3], [0, 3, 2]]
NAN = np.where(np.arange(12).reshape(4, 3) == 4, np.nan, POINTS)


@pytest.mark.parametrize(
    ("form", "change", "said"),
    [
        ("ascii", {"points": NAN}, "a.ply, line 13: not finite: '1.5 nan 0.0 7'"),
        ("ascii", {"faces": QUAD}, "a.ply, line 17: a face of 4 corners, no triangle"),
        ("ascii", {"faces": FACES + 1}, "a.ply: face 2 has the vertex 4, counted from 0"),
        ("binary_little_endian", {"points": NAN}, "a.ply: vertex 2 is not finite"),
        ("binary_big_endian", {"faces": QUAD}, "a.ply: face 2 has 4 corners, not a triangle"),
        ("binary_little_endian", {"faces": FACES - 1}, "a.ply: face 1 has the vertex -1"),
    ],
)
def test_ply_that_is_wrong_is_refused_with_its_place(form, change, said):
    with pytest.raises(ScanError) as refused:
        read_scan("a.ply", ply(form, **change))
    assert str(refused.value).startswith(said)


@pytest.mark.parametrize("form", FORMS)
def test_ply_that_is_cut_off_is_refused(form):
    whole = ply(form)
    start = whole.index(b"end_header\n") + len(b"end_header\n")
    for length in (len(whole) - 12, start + 40, start):
        with pytest.raises(ScanError, match=r"^a.ply: cut off .*after \d of 4 elements"):
            read_scan("a.ply", whole[:length])
    with pytest.raises(ScanError, match="header is cut off"):
        read_scan("a.ply", whole[: start - 8])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (b"ply\n", b"obj\n", "not a PLY file"),
        (b"ascii", b"latin", "unknown PLY format 'latin'"),
        (b"element face", b"element fact", "no element 'face'"),
        (b"double z", b"double w", "no x, y and z"),
        (b"double z", b"triple z", "line 7: cannot be read: 'property triple z'"),
        (b"vertex 4", b"vertex four", "line 4: cannot be read"),
        (b"property list uchar int", b"property int", "no list of vertices"),
        (b"1.5 0.0 0.0 7", b"1.5 0.0 x 7", "line 13: not a number: '1.5 0.0 x 7'"),
        (b"1.5 0.0 0.0 7", b"1.5 0.0 0.0", "line 13: 3 numbers, expected 4"),
    ],
)
def test_ply_with_another_header_or_line_is_refused(old, new, said):
    content = ply("ascii")
    assert old in content
    with pytest.raises(ScanError) as refused:
        read_scan("a.ply", content.replace(old, new))
    assert said in str(refused.value)
