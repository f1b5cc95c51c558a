"""Chapter 01, noise: what an answer to each exercise must do."""

import numpy as np

from mcdenoise.classroom import assert_matches, graded, picture

# The lens of the scene dof, and pixels per scene unit on its plane of focus in an image 128 pixels wide.
LENS_RADIUS, FOCUS_DISTANCE, PIXELS_PER_UNIT = 0.22, 5.3, 39.5


def _noise(*shape, seed=0):
    return np.random.default_rng(seed).random(shape)


def _array(received, shape, what):
    assert received is not None, f"{what}: nothing came back (None): is the `return` missing?"
    array = np.asarray(received, float)
    assert array.shape == shape, f"{what}: shape {shape} is needed, yours is {array.shape}."
    assert np.isfinite(array).all(), f"{what}: there are NaN or infinite values."
    return array


def _compare(received, expected, slips, what, rtol=1e-6):
    """Name the typical slips by name; everything else is left to the comparison."""
    try:
        values = np.asarray(received, float)
    except (TypeError, ValueError):
        values = np.empty(0)
    close = values.shape == np.shape(expected) and np.allclose(values, expected, rtol=rtol)
    for slip, wrong in slips.items():
        if not close and values.shape == np.shape(wrong) and np.allclose(values, wrong, rtol=1e-5, atol=1e-12):
            raise AssertionError(f"{what}: {slip}.")
    assert_matches(received, expected, what, rtol=rtol)


# variance_of_mean(samples) -> (h, w, c)


def _sum_of_squares(samples):
    """Sum over the samples of (x - mean)^2, and their number."""
    count = samples.shape[2]
    mean = sum(samples[:, :, k] for k in range(count)) / count
    return sum((samples[:, :, k] - mean) ** 2 for k in range(count)), count


def _compare_variance(received, samples, what):
    squares, n = _sum_of_squares(samples)
    slips = {
        "this is the variance of the samples; their mean varies spp times less": squares / (n - 1),
        "this is the variance of the samples (and divided by spp where spp - 1 is needed)": squares / n,
        "the squares are divided by spp where spp - 1 is needed (ddof=1): too small": squares / n**2,
        "divided by spp - 1 twice; the second time it is spp": squares / (n - 1) ** 2,
        "this is the variance of the sum of the samples, not of their mean": squares / (n - 1) * n,
        "this is the standard deviation of the mean; the variance is its square": np.sqrt(squares / (n - 1) / n),
        "this is the standard deviation of the samples": np.sqrt(squares / (n - 1)),
        "the squares are summed, not averaged": squares,
        "this is the mean of the samples, not its variance": samples.mean(axis=2),
        "divided by the number of rows, len(samples); there are samples.shape[2] samples": (
            squares / (n - 1) / len(samples)
        ),
    }
    for axis, name in ((0, "rows"), (1, "columns"), (3, "channels")):
        over = samples.var(axis=axis, ddof=1) / samples.shape[axis] if samples.shape[axis] > 1 else np.empty(0)
        slips[f"the statistics run over the {name} (axis {axis}); the samples are axis 2"] = over
    _compare(received, squares / (n - 1) / n, slips, what)


@graded("variance_of_mean", points=1)
def test_three_samples_by_hand(impl):
    "The samples 1, 3, 8 have the mean 4 and the variance (9 + 1 + 16) / 2 = 13; their mean has 13 / 3."
    samples = np.array([1.0, 3.0, 8.0]).reshape(1, 1, 3, 1)
    _compare_variance(impl(samples), samples, "for the samples 1, 3, 8")


@graded("variance_of_mean", points=0.5)
def test_each_pixel_and_channel_by_itself(impl):
    "Every pixel and channel gets its own variance: (h, w, spp, c) becomes (h, w, c)."
    samples = _noise(4, 5, 7, 3)
    received = impl(samples)
    _compare_variance(received, samples, "for noise of shape (4, 5, 7, 3)")


@graded("variance_of_mean", points=0.5)
def test_only_differences_count(impl):
    "Equal samples have no variance, and adding 100 to all samples changes nothing."
    assert_matches(impl(np.full((2, 3, 4, 1), 0.7)), np.zeros((2, 3, 1)), "for samples that are all 0.7", atol=1e-12)
    samples = _noise(2, 3, 6, 3, seed=1)
    _compare_variance(impl(samples + 100.0), samples, "for samples with 100 added")


@graded("variance_of_mean", points=1, hidden=True)
def test_it_is_unbiased(impl):
    "Averaged over many pixels it is the true variance of the mean, at 2 spp and at 16."
    for spp in (2, 16):
        pixels = 3000
        received = _array(impl(_noise(pixels, 1, spp, 1, seed=spp)), (pixels, 1, 1), f"at {spp} spp")
        true = 1 / 12 / spp
        error = 4 * true * np.sqrt(2 / (spp - 1) / pixels)
        assert abs(received.mean() - true) < error, (
            f"at {spp} spp the mean over {pixels} pixels is {received.mean():.5f}, the true variance is {true:.5f}."
        )


@picture("variance_of_mean")
def picture_variance_of_mean(impl):
    spread = np.linspace(0.1, 1.6, 48)[np.newaxis, :, np.newaxis, np.newaxis]
    samples = 0.5 + spread * (_noise(32, 48, 8, 1, seed=2) - 0.5)
    squares, n = _sum_of_squares(samples)
    return 20 * np.asarray(impl(samples), float)[..., 0], 20 * (squares / (n - 1) / n)[..., 0]


# relmse(image, reference, epsilon) -> a number


def _compare_relmse(received, image, reference, epsilon, what):
    error, square = (image - reference) ** 2, reference**2
    with np.errstate(all="ignore"):
        slips = {
            "this is the mean squared error: divide each pixel's by reference² + epsilon": error.mean(),
            "summed where the mean is needed": (error / (square + epsilon)).sum(),
            "the square root of what is expected": np.sqrt((error / (square + epsilon)).mean()),
            "epsilon is added after the division; it belongs to reference², inside": (error / square + epsilon).mean(),
            "epsilon is left out": (error / square).mean(),
            "epsilon is squared": (error / (square + epsilon**2)).mean(),
            "the mean of the errors is divided by the mean of reference² + epsilon; divide pixel by pixel, then average": (
                error.mean() / (square + epsilon).mean()
            ),
            "divided by the image's square; the reference's is needed": (error / (image**2 + epsilon)).mean(),
            "divided by the reference without its square": (error / (np.abs(reference) + epsilon)).mean(),
            "the difference is not squared": (np.abs(image - reference) / (square + epsilon)).mean(),
            "averaged over pixels and summed over channels": (error / (square + epsilon)).mean(axis=(0, 1)).sum(),
        }
    for slip in [name for name, value in slips.items() if not np.isfinite(value)]:
        del slips[slip]
    if np.ndim(received) == 3:
        raise AssertionError(f"{what}: an array came back; average over pixels and channels to one number.")
    _compare(received, (error / (square + epsilon)).mean(), slips, what)


@graded("relmse", points=0.5)
def test_one_pixel_by_hand(impl):
    "A pixel of 3 where the reference is 1 gives 4 / 1.01."
    image, reference = np.full((1, 1, 1), 3.0), np.full((1, 1, 1), 1.0)
    _compare_relmse(impl(image, reference, 0.01), image, reference, 0.01, "for 3 against 1")


@graded("relmse", points=1)
def test_noise_against_noise(impl):
    "The mean over all pixels and channels, each with its own division."
    image, reference = 1.5 * _noise(6, 7, 3), 0.2 + _noise(6, 7, 3, seed=1)
    _compare_relmse(impl(image, reference, 0.02), image, reference, 0.02, "for two images of noise")


@graded("relmse", points=0.5)
def test_black_pixels_count_with_epsilon(impl):
    "A black reference does not divide by 0: an error of 0.1 there counts 0.01 / epsilon."
    image, reference = np.full((2, 2, 1), 0.1), np.zeros((2, 2, 1))
    received = impl(image, reference, 0.01)
    assert np.isfinite(np.asarray(received, float)).all(), (
        "where the reference is black the result is infinite: epsilon belongs into the denominator, reference² + epsilon."
    )
    _compare_relmse(received, image, reference, 0.01, "for a black reference")


@graded("relmse", points=1, hidden=True)
def test_relmse_at_its_limits(impl):
    "Equal images have no error; the sign of the error and bright pixels are no special cases; epsilon is used."
    image, reference = 30 * _noise(3, 4, 3, seed=2), 5 * _noise(3, 4, 3, seed=3)
    assert_matches(impl(reference, reference, 0.01), 0.0, "for equal images", atol=1e-12)
    for epsilon in (1e-4, 0.01, 1.0):
        _compare_relmse(impl(image, reference, epsilon), image, reference, epsilon, f"with epsilon {epsilon:g}")


# spp_needed: (spp for half the RMS error, spp for half the relMSE), from 16 spp


@graded("spp_needed", points=2)
def test_spp_needed(impl):
    "From 16 spp: how many for half the RMS error, and how many for half the relMSE?"
    values = np.asarray(impl, float)
    assert values.shape == (2,), (
        f"two numbers are asked for, spp for half the RMS error first; got shape {values.shape}."
    )
    half_rms, half_relmse = values
    assert (half_rms, half_relmse) != (32, 64), (
        "the two are exchanged: relMSE is a variance, which falls as 1 / N; the RMS error is its square root."
    )
    for value, right, name, slips in (
        (
            half_rms,
            64,
            "RMS error",
            {32: "that halves the variance; the RMS error is its root", 256: "that quarters the RMS error"},
        ),
        (
            half_relmse,
            32,
            "relMSE",
            {64: "relMSE is a squared error already: it falls as 1 / N", 256: "relMSE falls as 1 / N"},
        ),
    ):
        assert value > 16, f"half the {name} needs more than the 16 spp at hand, yours is {value:g}."
        assert value not in slips, f"half the {name} at {value:g} spp? {slips[value]}."
        assert value == right, f"half the {name} is not at {value:g} spp. By which factor must N grow?"


# firefly(u) -> values (n,)


def _check_firefly(impl, seed):
    grid = (np.arange(200_000) + (0.25 if seed else 0.5)) / 200_000
    values = _array(impl(grid), grid.shape, "the values")
    assert values.min() >= 0, f"radiance is never negative, yours goes down to {values.min():.4g}."
    assert abs(values.mean() - 1) < 0.02, (
        f"the mean over u in [0, 1) must be 1, yours is {values.mean():.4g}: divide by it."
    )
    true = values.var() / 16
    assert true > 1e-9, "your samples do not vary at all: then a variance of 0 is right, and nothing is underestimated."
    u = np.random.default_rng(seed).random(16 * 4000)
    drawn = _array(impl(u), u.shape, "the values for random u")
    _check_each_by_itself(impl, np.append(grid, u), np.append(values, drawn), seed)
    estimated = drawn.reshape(4000, 16).var(axis=1, ddof=1) / 16
    share = float(np.mean(estimated < 0.1 * true))
    assert share >= 0.9, (
        f"in {100 * share:.0f} % of the pixels the estimated variance of the mean is below a tenth of the true one "
        f"({true:.4g}); 90 % are asked for. Let nearly all of the mean come from few values of u."
    )


def _check_each_by_itself(impl, u, values, seed):
    """Most of the same u again, mixed: each must get the value that it had."""
    rng = np.random.default_rng(100 + seed)
    chosen = rng.permutation(u.size)[: u.size - rng.integers(1, 1000)]
    again = _array(impl(u[chosen]), chosen.shape, "the values for mixed u")
    assert np.allclose(again, values[chosen], rtol=1e-9, atol=0), (
        "each value may depend on its own u alone: the same u in another order, among others, gave other values. (Where "
        "the values are divided by their mean, that must be a fixed number.)"
    )


@graded("firefly", points=1)
def test_samples_that_look_quiet(impl):
    "The mean is 1, and in 9 of 10 pixels of 16 spp the estimated variance is below a tenth of the true one."
    _check_firefly(impl, 0)


@graded("firefly", points=1, hidden=True)
def test_also_with_other_random_numbers(impl):
    "Also with other random numbers, and for a single one."
    _check_firefly(impl, 1)
    _array(impl(np.array([0.25])), (1,), "the value for a single u")


# light_field_slope(depth, focus_distance, lens_radius, pixels_per_unit) -> pixels


def _slope(depth, focus_distance, lens_radius, pixels_per_unit):
    return 2 * lens_radius * pixels_per_unit * (focus_distance - depth) / depth


def _compare_slope(received, depth, focus_distance, lens_radius, pixels_per_unit, what):
    scale = 2 * lens_radius * pixels_per_unit
    right = _slope(depth, focus_distance, lens_radius, pixels_per_unit)
    slips = {
        "the sign is flipped: in front of the plane of focus the slope is positive": -right,
        "half of what is expected: u from 0 to 1 crosses the whole lens, 2 lens_radius": right / 2,
        "in scene units: multiply by pixels_per_unit": right / pixels_per_unit,
        "in scene units, and half: 2 lens_radius and pixels_per_unit are needed": right / (2 * pixels_per_unit),
        "the sign is lost (an absolute value)": np.abs(right),
        "not divided by depth: the cone of rays narrows to the point": right * depth,
        "divided by focus_distance; the cone ends at the point, so divide by depth": right * depth / focus_distance,
        "the - 1 is missing: a point in focus must stay where it is": scale * focus_distance / depth,
        "depth / focus_distance is upside down": scale * (depth / focus_distance - 1),
        "depth / focus_distance is upside down and the sign too": -scale * (depth / focus_distance - 1),
        "divided by pixels_per_unit; multiply": right / pixels_per_unit**2,
    }
    _compare(received, right, slips, what)


@graded("light_field_slope", points=0.5)
def test_a_point_in_focus_stands_still(impl):
    "On the plane of focus the slope is 0, in front of it positive, behind it negative."
    in_focus = impl(5.3, 5.3, 0.22, 39.5)
    near, far = impl(4.0, 5.3, 0.22, 39.5), impl(8.0, 5.3, 0.22, 39.5)
    assert_matches(in_focus, 0.0, "the slope of a point in focus", atol=1e-9)
    assert not (np.all(np.sign(near) == 1) and np.all(np.sign(far) == 1)), (
        "the slope is positive in front of the plane of focus and behind it: the sign is lost (an absolute value)."
    )
    assert_matches(np.sign(near), 1.0, "the sign of the slope of a point in front")
    assert_matches(np.sign(far), -1.0, "the sign of the slope of a point behind")


@graded("light_field_slope", points=1)
def test_slopes_of_many_depths(impl):
    "Many depths at once, for two lenses."
    depth = np.array([2.0, 3.3, 4.5, 6.7, 8.3, 20.0])
    for focus_distance, lens_radius, pixels_per_unit in ((5.3, 0.22, 39.5), (4.0, 0.5, 25.0)):
        received = impl(depth, focus_distance, lens_radius, pixels_per_unit)
        what = f"slopes for focus_distance {focus_distance}, lens_radius {lens_radius}"
        _compare_slope(received, depth, focus_distance, lens_radius, pixels_per_unit, what)


@graded("light_field_slope", points=0.5, hidden=True)
def test_slopes_at_the_limits(impl):
    "Far away the slope is minus the lens diameter in pixels; at half the distance of focus it is plus that."
    depth = np.array([1e9, 2.5])
    _compare_slope(impl(depth, 5.0, 0.3, 40.0), depth, 5.0, 0.3, 40.0, "slopes very far away and at half the distance")
    assert_matches(impl(1e9, 5.0, 0.3, 40.0), -24.0, "the slope of a point very far away")
    assert_matches(impl(2.5, 5.0, 0.3, 40.0), 24.0, "the slope at half the distance of focus")
    depth = 1 + 9 * _noise(3, 4)
    _compare_slope(impl(depth, 6.1, 0.1, 55.0), depth, 6.1, 0.1, 55.0, "slopes of a table of depths")


# crossing_samples: two rows of x, u, depth


@graded("crossing_samples", points=2)
def test_crossing_samples(impl):
    "Two samples at most 3 pixels apart whose trajectories cross on the lens."
    samples = _array(impl, (2, 3), "two rows of x, u, depth")
    (x_1, u_1, depth_1), (x_2, u_2, depth_2) = samples
    assert (np.abs(samples[:, 1] - 0.5) <= 0.5).all(), "u lies between 0 and 1: the samples are on the lens."
    assert samples[:, 2].min() > 0, "depths are above 0: the points lie in front of the lens."
    assert abs(x_1 - x_2) <= 3, (
        f"the samples are {abs(x_1 - x_2):.3g} pixels apart on the screen; at most 3 are allowed."
    )
    assert depth_1 != depth_2, "both have one depth, so their trajectories are parallel and never cross."
    slope_1, slope_2 = (_slope(d, FOCUS_DISTANCE, LENS_RADIUS, PIXELS_PER_UNIT) for d in (depth_1, depth_2))
    at_0 = x_1 - slope_1 * u_1 - (x_2 - slope_2 * u_2)
    at_1 = at_0 + slope_1 - slope_2
    crossing = at_0 / (slope_2 - slope_1)
    assert at_0 * at_1 < 0, (
        f"the trajectories cross at u = {crossing:.3g}, not on the lens between 0 and 1: they could lie on one surface. "
        f"Their slopes are {slope_1:.3g} and {slope_2:.3g} pixels."
    )


# refocus(light_field, slope) -> (n_x, c)


def _refocus(light_field, slope, centre=0.5, sign=1):
    """By weights of two neighbouring columns; the border column is repeated."""
    rows, columns, _ = light_field.shape
    total = np.zeros(light_field.shape[1:])
    for k, row in enumerate(light_field):
        place = np.clip(np.arange(columns) + sign * slope * ((k + 0.5) / rows - centre), 0, columns - 1)
        left = np.minimum(place.astype(int), max(columns - 2, 0))
        share = (place - left)[:, np.newaxis]
        total += (1 - share) * row[left] + share * row[np.minimum(left + 1, columns - 1)]
    return total / rows


def _compare_refocus(received, light_field, slope, what):
    right = _refocus(light_field, slope)
    slips = {
        "the rows are shifted the wrong way: read at x + slope (u - 1/2)": _refocus(light_field, slope, sign=-1),
        "off centre: the rows are shifted by slope u; the middle of the lens (u = 1/2) must stay": _refocus(
            light_field, slope, centre=0.0
        ),
        "summed over u where the mean is needed": right * len(light_field),
        "nothing is shifted: this is the plain mean over u": light_field.mean(axis=0),
        "only the middle row came back: average all rows": light_field[len(light_field) // 2],
    }
    _compare(received, right, slips, what)


def _trajectory(slope, rows=12, columns=40, middle=20.0):
    """A light field of one point: a smooth bright spot that moves by `slope` columns while u goes from 0 to 1."""
    u = ((np.arange(rows) + 0.5) / rows)[:, np.newaxis]
    place = middle + slope * (u - 0.5)
    spot = np.exp(-((np.arange(columns) - place) ** 2) / 8)
    return spot[..., np.newaxis] * np.array([1.0, 0.6, 0.2])


@graded("refocus", points=0.5)
def test_without_slope_it_is_the_mean_over_u(impl):
    "With slope 0 it is the mean over u."
    light_field = _noise(6, 9, 3)
    received = impl(light_field, 0.0)
    if np.shape(received) == (6, 3):
        raise AssertionError("averaged over x (axis 1); u is axis 0, and (n_x, c) must come back.")
    _compare(
        received,
        light_field.mean(axis=0),
        {"summed over u where the mean is needed": light_field.sum(axis=0)},
        "for slope 0",
    )


@graded("refocus", points=1)
def test_a_point_becomes_sharp_at_its_own_slope(impl):
    "A point becomes sharp at its own slope, and stays where the middle of the lens sees it."
    for slope in (8.0, -6.0):
        light_field = _trajectory(slope)
        _compare_refocus(impl(light_field, slope), light_field, slope, f"for a point of slope {slope:g}")


@graded("refocus", points=0.5)
def test_between_columns_it_interpolates(impl):
    "Between two columns the radiance is interpolated linearly; at the border the last column is repeated."
    light_field = _noise(4, 12, 3, seed=5)
    _compare_refocus(impl(light_field, 2.6), light_field, 2.6, "for noise and slope 2.6")


@graded("refocus", points=1, hidden=True)
def test_other_sizes_and_slopes(impl):
    "Other sizes, one channel, one row, slopes larger than the row."
    for shape, slope in (((1, 7, 3), 4.0), ((5, 8, 1), -3.3), ((7, 6, 2), 30.0)):
        light_field = _noise(*shape, seed=6)
        _compare_refocus(impl(light_field, slope), light_field, slope, f"for shape {shape} and slope {slope:g}")


@picture("refocus")
def picture_refocus(impl):
    near, far = _trajectory(9.0, middle=12.0), _trajectory(-6.0, middle=28.0)[..., ::-1]
    light_field = near + far
    row, target = np.asarray(impl(light_field, 9.0), float), _refocus(light_field, 9.0)
    return np.repeat(row[np.newaxis], 12, axis=0), np.repeat(target[np.newaxis], 12, axis=0)
