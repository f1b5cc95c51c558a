"""The filter as a layer: closed forms, the ladder of filters, gradients, and the fast twin."""

import re

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdenoise.filters import cross_bilateral, gaussian, nlm
from mcdenoise.lbf.layer import COLOUR_EPSILON, LEAST_VARIANCE, VARIANTS, FilterLayer
from mcdenoise.lbf.loss import Example, FilterLoss
from mcdenoise.lbf.model import LBFModel
from mcdenoise.lbf.primary import Primary
from mcdenoise.lbf.untextured import untextured
from mcdenoise.nn import check_gradient

pytestmark = pytest.mark.ch09

CHANNELS = {"world_position": 3, "shading_normal": 3, "albedo": 3, "albedo_2": 3, "visibility": 1}


def primary_of(seed, height, width, groups=("albedo", "visibility"), spp=4, dtype=np.float32):
    """Random colours, variances and features."""
    rng = np.random.default_rng(seed)
    features = {name: rng.random((height, width, CHANNELS[name])).astype(dtype) for name in groups}
    variances = {name: (0.1 * rng.random(one.shape)).astype(dtype) for name, one in features.items()}
    colour, variance = rng.random((height, width, 3)).astype(dtype), rng.random((height, width, 3)).astype(dtype)
    return Primary(colour, 0.05 * variance, features, features, variances, spp)


def theta_of(layer, seed=0, scale=0.2):
    theta = np.random.default_rng(seed).random(layer.shape) * scale
    theta[..., 0] *= 0.2
    return theta


@pytest.mark.parametrize("engine", ["numpy", "numba"])
def test_two_pixels_by_hand(engine):
    """One neighbour: every distance can be written down."""
    colour = np.array([[[1.0, 2.0, 3.0], [2.0, 0.0, 3.0]]], np.float32)
    variance = np.array([[[0.5, 1.0, 1.0], [0.5, 1.0, 2.0]]], np.float32)
    albedo, psi = np.array([[[0.2] * 3, [0.5] * 3]], np.float32), np.array([[[0.01] * 3, [1e-9] * 3]], np.float32)
    layer = FilterLayer(
        Primary(colour, variance, {"albedo": albedo}, {"albedo": albedo}, {"albedo": psi}, 4), engine=engine
    )
    theta = np.array([[[0.1, 0.2, 0.01], [0.1, 0.2, 0.001]]])
    filtered, (_, _, norm) = layer.forward(theta)
    of_colour = 1 / 1 + 4 / 2
    weights = np.exp(
        [-0.1 - 0.2 * of_colour - 0.01 * 3 * 0.09 / 0.01, -0.1 - 0.2 * of_colour - 0.001 * 3 * 0.09 / LEAST_VARIANCE]
    )
    np.testing.assert_allclose(norm[0], 1 + weights, rtol=1e-5)
    expected = (colour[0] + weights[:, np.newaxis] * colour[0, ::-1]) / (1 + weights[:, np.newaxis])
    np.testing.assert_allclose(filtered[0], expected, rtol=1e-5)


@pytest.mark.parametrize("engine", ["numpy", "numba"])
def test_position_alone_is_the_gaussian(engine):
    primary = primary_of(1, 12, 40, ())
    layer = FilterLayer(primary, radius=9, engine=engine)
    theta = np.zeros(layer.shape)
    theta[..., 0] = 1 / (2 * 2.5**2)
    expected = gaussian(primary.colour, sigma_space=2.5, radius=9, engine="numpy")
    np.testing.assert_allclose(layer.forward(theta)[0], expected, rtol=2e-5)


@pytest.mark.parametrize("engine", ["numpy", "numba"])
def test_one_bandwidth_everywhere_is_the_cross_bilateral_filter(engine):
    """With one variance everywhere, v_i + v_j = 2 v and psi^2 only change the unit of sigma."""
    primary = primary_of(2, 11, 13, ("albedo",))
    flat = Primary(
        primary.colour, np.full_like(primary.colour, 0.02), primary.raw, primary.features,
        {"albedo": np.full_like(primary.colour, 0.03)}, 4,
    )  # fmt: skip
    layer = FilterLayer(flat, radius=5, engine=engine)
    theta = np.broadcast_to([1 / (2 * 3.0**2), 0.4, 0.7], layer.shape)
    expected = cross_bilateral(
        primary.colour, {"albedo": primary.features["albedo"]}, sigma_space=3.0,
        sigma_radiance=np.sqrt((0.04 + COLOUR_EPSILON) / (2 * 0.4)), sigma_features={"albedo": np.sqrt(0.03 / (2 * 0.7))},
        radius=5, engine="numpy",
    )  # fmt: skip
    np.testing.assert_allclose(layer.forward(theta)[0], expected, rtol=3e-5)


@pytest.mark.parametrize("engine", ["numpy", "numba"])
def test_patches_alone_are_nl_means(engine):
    primary = primary_of(3, 14, 17, ())
    layer = FilterLayer(primary, variant="nlm", radius=4, patch_radius=2, engine=engine)
    theta = np.broadcast_to([0.0, 1.0], layer.shape)
    expected = nlm(primary.colour, primary.colour_variance, search_radius=4, patch_radius=2, k=1.0, engine="numpy")
    np.testing.assert_allclose(layer.forward(theta)[0], expected, rtol=3e-5)


@pytest.mark.parametrize("variant", VARIANTS)
def test_limits(variant):
    """Theta 0 is the plain mean of the window, a huge theta of position leaves the image as it is."""
    primary = primary_of(4, 8, 9)
    layer = FilterLayer(primary, variant=variant, radius=30)
    np.testing.assert_allclose(
        layer.forward(np.zeros(layer.shape))[0], np.broadcast_to(primary.colour.mean((0, 1)), (8, 9, 3)), rtol=1e-5
    )
    theta = np.zeros(layer.shape)
    theta[..., 0] = 1e8
    filtered, saved = layer.forward(theta)
    np.testing.assert_array_equal(filtered, primary.colour)
    np.testing.assert_array_equal(layer.backward(np.ones((8, 9, 3)), saved), 0)


@settings(max_examples=25, deadline=None)
@given(
    st.integers(1, 12), st.integers(1, 40), st.sampled_from((0, 1, 4, 27)), st.sampled_from(VARIANTS), st.integers(0, 3),
    st.sampled_from(((), ("albedo",), tuple(CHANNELS))),
)  # fmt: skip
def test_the_kernel_computes_the_same(height, width, radius, variant, patch_radius, groups):
    """Forward and backward, images smaller than the window and the patch included, on some rows."""
    primary = primary_of(height * width, height, width, groups)
    rows = np.unique(np.random.default_rng(0).integers(0, height, 3))
    shared = {"variant": variant, "radius": radius, "patch_radius": patch_radius, "rows": rows}
    exact, fast = (FilterLayer(primary, engine=engine, **shared) for engine in ("numpy", "numba"))
    theta, d_filtered = theta_of(exact), np.random.default_rng(1).normal(size=(*exact.shape[:2], 3))
    expected, kept = exact.forward(theta)
    received, kept_fast = fast.forward(theta)
    assert received.dtype == np.float32
    np.testing.assert_allclose(received, expected, atol=3e-6)
    np.testing.assert_allclose(kept_fast[2], kept[2], rtol=2e-5)
    gradient = exact.backward(d_filtered, kept)
    scale = max(np.abs(gradient).max(), 1e-3)
    np.testing.assert_allclose(fast.backward(d_filtered, kept_fast), gradient, atol=3e-5 * scale)


def test_rows_are_those_of_the_whole_image_at_any_number_of_threads():
    primary = primary_of(5, 40, 21)
    whole, some = FilterLayer(primary), FilterLayer(primary, rows=[3, 17, 38])
    theta = theta_of(whole)
    d_filtered = np.random.default_rng(2).normal(size=(40, 21, 3))

    def run(layer, rows):
        filtered, saved = layer.forward(theta[rows])
        return filtered, layer.backward(d_filtered[rows], saved)

    before = numba.get_num_threads()
    try:
        numba.set_num_threads(1)
        one = run(whole, slice(None))
        numba.set_num_threads(numba.config.NUMBA_NUM_THREADS)
        for a, b, c in zip(one, run(whole, slice(None)), run(some, [3, 17, 38]), strict=True):
            np.testing.assert_array_equal(a, b)
            np.testing.assert_array_equal(a[[3, 17, 38]], c)
    finally:
        numba.set_num_threads(before)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("radius", [1, 3, 9])
def test_gradient_of_every_theta_by_central_differences(variant, radius):
    """On 4 x 6 pixels every window is cut by a border."""
    primary = primary_of(6, 4, 6, tuple(CHANNELS), dtype=np.float64)
    albedo = np.random.default_rng(1).uniform(0.2, 1, (4, 6, 3))
    layer = FilterLayer(primary, variant=variant, radius=radius, patch_radius=1, albedo=albedo, engine="numpy")
    pair = layer.forward, lambda d_filtered, saved: {"theta": layer.backward(d_filtered, saved)}
    assert check_gradient(pair, {"theta": 0.02 + theta_of(layer)}, tolerance=1e-6) < 1e-6


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("colour_theta", [0.05, None])
def test_gradient_of_every_weight_by_central_differences(variant, colour_theta):
    """The whole chain: network, softplus, filter, relative error; two images, one lacks a group."""
    groups = ("world_position", "albedo")
    model = LBFModel.random(
        groups, hidden=[3], rng=np.random.default_rng(7), dtype=np.float64, variant=variant, radius=2, patch_radius=1,
        colour_theta=colour_theta,
    )  # fmt: skip
    rng, examples = np.random.default_rng(8), []
    for own, spp in ((groups, 4), (("albedo",), 8)):
        layer = model.layer(primary_of(spp, 5, 6, own, spp, np.float64), rows=[0, 2, 4], engine="numpy")
        examples.append(Example(layer, rng.normal(size=(18, model.network.inputs)), rng.random((18, 3))))
    loss = FilterLoss(model, examples)
    x, target = (np.concatenate([getattr(one, name) for one in examples]) for name in ("inputs", "target"))

    def forward(**parameters):
        y, saved = model.network.replace(parameters).forward(x)
        value, kept = loss.forward(y, target)
        return np.array(value), (parameters, saved, kept)

    def backward(d_value, saved):
        parameters, of_network, kept = saved
        return model.network.replace(parameters).gradients(d_value * loss.backward(kept), of_network)

    assert check_gradient((forward, backward), dict(model.network.parameters), tolerance=1e-5) < 1e-5


def test_colours_divided_by_albedo_come_back_multiplied():
    """A texture under even light: without texture it is flat, and the filter leaves the image as it is."""
    texture = np.random.default_rng(10).uniform(0.2, 1, (6, 7, 3)).astype(np.float32)
    still = {"albedo": 0 * texture}
    textured = Primary(0.7 * texture, 0.01 * texture, {"albedo": texture}, {"albedo": texture}, still, 4)
    compared, albedo = untextured(textured)
    np.testing.assert_allclose(compared.colour, 0.7, rtol=1e-6)
    np.testing.assert_allclose(compared.colour_variance * texture, 0.01, rtol=1e-5)
    for engine in ("numpy", "numba"):
        layer = FilterLayer(compared, albedo=albedo, rows=[1, 4], engine=engine)
        np.testing.assert_allclose(layer.noisy, textured.colour[[1, 4]], rtol=1e-6)
        np.testing.assert_allclose(layer.forward(theta_of(layer))[0], textured.colour[[1, 4]], rtol=1e-5)
    bare, nothing = untextured(textured.select([]))
    assert nothing is None
    np.testing.assert_array_equal(bare.colour, textured.colour)


@pytest.mark.parametrize("engine", ["numpy", "numba"])
def test_a_model_divides_and_multiplies(engine):
    primary = primary_of(11, 6, 9, ("albedo",))
    model = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0), radius=3)
    layer, theta = model.layer(primary, engine=engine), model.theta(primary)
    compared, albedo = untextured(primary)
    plain = FilterLayer(compared, radius=3, engine=engine)
    np.testing.assert_allclose(layer.forward(theta)[0], plain.forward(theta)[0] * albedo, rtol=1e-6)
    without = LBFModel.random(["albedo"], hidden=[2], rng=np.random.default_rng(0), divides_albedo=False)
    assert without.layer(primary).albedo is None


def test_black_albedo_is_not_divided_by():
    black = {"albedo": np.zeros((2, 2, 3), np.float32)}
    compared, albedo = untextured(Primary(np.ones((2, 2, 3), np.float32), black["albedo"], black, black, black, 4))
    np.testing.assert_allclose(albedo, 0.1)
    np.testing.assert_allclose(compared.colour, 10)


@pytest.mark.parametrize("albedo", [np.ones((5, 6)), np.zeros((5, 6, 3)), np.full((5, 6, 3), np.nan)])
def test_an_albedo_that_cannot_be_divided_by_is_refused(albedo):
    with pytest.raises(
        ValueError, match=r"albedo must have the shape of the colours, \(5, 6, 3\), and be above 0; got shape"
    ):
        FilterLayer(primary_of(1, 5, 6), albedo=albedo)


def test_extreme_numbers_stay_finite():
    """Fireflies, black pixels, features without variance, colours without noise: no NaN, no overflow."""
    primary = primary_of(9, 9, 11, tuple(CHANNELS))
    colour, variance = primary.colour.copy(), primary.colour_variance.copy()
    colour[4, 4], variance[4, 4] = 1e15, 1e29
    colour[2], variance[2] = 0, 0
    features = {name: one * (1e20 if name == "world_position" else 1) for name, one in primary.features.items()}
    still = {name: np.zeros_like(one) for name, one in features.items()}
    for variant in VARIANTS:
        layer = FilterLayer(Primary(colour, variance, features, features, still, 4), variant=variant)
        for theta in (0.0, 0.1, 1e8):
            filtered, saved = layer.forward(np.full(layer.shape, theta))
            assert np.isfinite(filtered).all()
            assert filtered.min() >= 0
            assert filtered.max() <= 1.0001e15
            assert np.isfinite(layer.backward(1e-12 * np.ones_like(filtered), saved)).all()


def test_memory_is_that_of_the_pixels_not_of_the_weights():
    layers = [FilterLayer(primary_of(1, 64, 64), variant="nlm", radius=radius) for radius in (2, 27)]
    kept = [sum(one.nbytes for one in layer.forward(theta_of(layer))[1]) for layer in layers]
    planes = [sum(one.nbytes for one in layer._planes[0]) for layer in layers]
    assert kept[0] == kept[1]
    assert planes[1] < 3 * planes[0]  # padding


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"variant": "median"}, "variant must be one of"),
        ({"engine": "fortran"}, "engine must be one of"),
        ({"radius": -1}, "radius must be"),
        ({"patch_radius": 1.5}, "patch_radius must be"),
        ({"rows": []}, "rows must be a list of row numbers from 0 to 4, got []."),
        ({"rows": [5]}, "rows must be a list of row numbers from 0 to 4, got [5]."),
        ({"rows": [0.5]}, "rows must be a list of row numbers"),
    ],
)
def test_bad_settings_are_refused(changes, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        FilterLayer(primary_of(1, 5, 6), **changes)


@pytest.mark.parametrize(
    ("theta", "message"),
    [
        (np.ones((5, 6, 3)), "theta must have shape (5, 6, 4): rows, columns and position, colour, albedo, visibility; got"),
        (np.full((5, 6, 4), np.nan), "theta"),
        (np.full((5, 6, 4), -1.0), "theta = 1 / (2 sigma^2) must lie in [0, 1e+08], got -1 to -1."),
        (np.full((5, 6, 4), 1e9), "got 1e+09 to 1e+09"),
    ],
)  # fmt: skip
def test_bad_theta_is_refused(theta, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        FilterLayer(primary_of(1, 5, 6)).forward(theta)


def test_whole_images_are_never_cut_into_parts():
    model = LBFModel.random(["albedo"], hidden=[1], rng=np.random.default_rng(0))
    loss = FilterLoss(model, [])
    assert loss.rows(slice(None)) is loss
    with pytest.raises(ValueError, match="full batches"):
        loss.rows(slice(0, 4))
