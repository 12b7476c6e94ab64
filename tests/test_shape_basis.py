import numpy as np

from model.shape_basis import load_shape_basis
from model.template_mesh import load_template_mesh


def test_bodies_stand_on_the_ground_in_the_middle() -> None:
    basis = load_shape_basis()
    random = np.random.default_rng(0)
    bodies = basis.vertices(random.normal(size=(5, len(basis.directions))))
    assert np.abs(bodies[..., 1].min(axis=1)).max() == 0
    mirrored = bodies[:, basis.mirror] * [-1, 1, 1]
    assert np.abs(mirrored - bodies).max() < 1e-6


def test_it_is_linear_but_for_the_ground() -> None:
    basis = load_shape_basis()
    random = np.random.default_rng(0)
    first, second = random.normal(size=(2, len(basis.directions)))
    bodies = basis.vertices(np.stack([first, second, (first + second) / 2]))
    middle = (bodies[0] + bodies[1]) / 2
    middle[:, 1] -= middle[:, 1].min()
    assert np.abs(middle - bodies[2]).max() < 1e-5


def test_it_fits_the_template() -> None:
    basis, template = load_shape_basis(), load_template_mesh()
    assert (basis.mirror == template.mirror).all()
    mean = basis.vertices(np.zeros((1, len(basis.directions))))[0]
    template_placed = template.vertices - [0, template.vertices[:, 1].min(), 0]
    assert np.abs(mean - template_placed).max() < 1e-4
