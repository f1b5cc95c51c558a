"""Chapter 02, the Gaussian filter: what an answer to each exercise must do."""

import numpy as np

import mcdenoise as mcd
from mcdenoise.classroom import assert_matches, graded, picture

# The sigma_space with the smallest relMSE at 8 spp, from the figure "Blur against noise" of the lecture.
BEST_SIGMA = {"pinhole": 0.38, "soft_shadow": 0.5, "dof": 0.66}


def _noise(*shape, seed=0):
    return np.random.default_rng(seed).random(shape)


def _line(size, sigma_space, radius):
    """The weights of one dimension as a matrix: row i holds the weight of every pixel j for pixel i."""
    distance = np.arange(size)[:, np.newaxis] - np.arange(size)
    return np.where(abs(distance) <= radius, np.exp(-(distance**2) / (2 * sigma_space**2)), 0.0)


def _sums(image, sigma_space, radius, *, rows_only=False):
    """Total and norm by matrix products: W_y image W_x."""
    height, width, _ = image.shape
    down = np.eye(height) if rows_only else _line(height, sigma_space, radius)
    along = _line(width, sigma_space, radius)
    return np.einsum("yi,xj,ijc->yxc", down, along, image), np.outer(down.sum(1), along.sum(1))


def _window(sigma_space, radius):
    line = _line(2 * radius + 1, sigma_space, 2 * radius)[radius]
    return np.outer(line, line)


def _array(received):
    assert received is not None, "nothing came back (None): is the `return` missing?"
    return np.asarray(received, float)


def _check_order(total, norm, image):
    if np.shape(total) == image.shape[:2] and np.shape(norm) == image.shape:
        raise AssertionError("the two results are swapped: total comes first, then norm.")


def _compare(received, image, sigma_space, radius, where, *, rows_only=False):
    total, norm = received
    expected_total, expected_norm = _sums(np.asarray(image, float), sigma_space, radius, rows_only=rows_only)
    _check_order(total, norm, image)
    if rows_only and np.shape(norm) == expected_norm.shape and image.shape[1] > 2 * radius:
        ends = ~np.isclose(norm, expected_norm).all(axis=0)
        assert ends[radius:-radius].any() or not ends.any(), (
            f"norm {where}: right in the middle of a row, wrong within {radius} pixels of its ends: only pixels inside the "
            f"row may count."
        )
    assert_matches(norm, expected_norm, f"norm {where}")
    if np.asarray(total).dtype.kind in "iu" and not np.array_equal(total, expected_total):
        raise AssertionError(
            f"total {where}: whole numbers came back, the decimals are cut off: start from zeros of type float."
        )
    assert_matches(total, expected_total, f"total {where}")


def _impulse(height=11, width=13, y=5, x=6, value=1.0):
    image = np.zeros((height, width, 1))
    image[y, x] = value
    return image


def _check_bell(received, sigma_space, expected, what):
    """Name the slips of the exponent by name; everything else is left to the comparison."""
    d = sigma_space * np.sqrt(-2 * np.log(expected))
    slips = {
        "the distance stands in the exponent without its square": np.exp(-d / (2 * sigma_space**2)),
        "the 2 of 2 sigma_space² is missing in the exponent": expected**2,
        "sigma_space stands in the exponent without its square": expected**sigma_space,
        "sigma_space stands in the exponent without its square and without its factor 2": expected ** (2 * sigma_space),
        "the sign of the exponent is wrong: the weight must fall with the distance": 1 / expected,
        "sigma_space multiplies where it should divide": expected ** (sigma_space**4),
    }
    for slip, values in slips.items():
        if np.shape(received) == expected.shape and np.allclose(received, values, rtol=1e-6, atol=0):
            raise AssertionError(f"{what}: {slip}.")
    assert_matches(received, expected, what)


def _check_reach(total, y, x, *, reach_y, reach_x):
    """Name the offsets that the window reaches, if they are not all."""
    rows, columns = np.nonzero(total)
    if len(rows) == 0:
        return
    assert total[y, x] != 0, "total around one bright pixel: the pixel itself, offset (0, 0), is left out of the sum."
    reached = [(int(rows.min() - y), int(rows.max() - y)), (int(columns.min() - x), int(columns.max() - x))]
    for name, (first, last), reach in (("dy", reached[0], reach_y), ("dx", reached[1], reach_x)):
        assert last - first == 2 * reach, (
            f"total around one bright pixel: it spreads over {last - first + 1} pixels in {name[1]}, for radius 4 it must "
            f"be {2 * reach + 1}: do the offsets {name} run from {-reach} to {reach}, both included?"
        )


# gaussian_weights(sigma_space, radius) -> (2 radius + 1, 2 radius + 1)


@graded("gaussian_weights", points=0.5)
def test_window_has_its_size_and_weight_1_in_the_middle(impl):
    "The window has 2 radius + 1 pixels a side, and the middle one has the weight 1."
    for radius in (2, 3):
        weights = _array(impl(1.5, radius))
        side = 2 * radius + 1
        assert weights.shape == (side, side), (
            f"for radius {radius} the window must have shape ({side}, {side}), yours has {weights.shape}."
        )
        assert np.isfinite(weights).all(), "there are NaN or infinite weights."
        middle, top = weights[radius, radius], np.unravel_index(weights.argmax(), weights.shape)
        assert top == (radius, radius), (
            f"the largest weight must stand in the middle, at ({radius}, {radius}); yours stands at "
            f"({top[0]}, {top[1]}): off centre, or it grows with the distance."
        )
        assert abs(middle - 1) < 1e-9, (
            f"the weight of a pixel with itself is exp(0) = 1, yours is {middle:.4g}: no constant in front, not normalised "
            f"(dividing by norm comes later)."
        )


@graded("gaussian_weights", points=0.5)
def test_weights_are_the_bell(impl):
    "The weight at distance d is exp(-d² / (2 sigma_space²))."
    for sigma_space, radius in ((1.5, 3), (0.8, 2)):
        what = f"weights for sigma_space {sigma_space}, radius {radius}"
        _check_bell(impl(sigma_space, radius), sigma_space, _window(sigma_space, radius), what)


@graded("gaussian_weights", points=1, hidden=True)
def test_weights_at_the_limits(impl):
    "A window of one pixel is [[1]]; a wide sigma_space makes all weights alike."
    assert_matches(impl(2.0, 0), np.ones((1, 1)), "weights for radius 0")
    assert_matches(impl(1e9, 4), np.ones((9, 9)), "weights for sigma_space 1e9, radius 4")
    _check_bell(impl(3.7, 9), 3.7, _window(3.7, 9), "weights for sigma_space 3.7, radius 9")


# gaussian_sums(image, sigma_space, radius) -> total (h, w, c), norm (h, w)


@graded("gaussian_sums", points=0.5)
def test_an_impulse_gives_the_bell(impl):
    "The response to one bright pixel is the bell, centred on it."
    total, norm = impl(_impulse(), 1.5, 4)
    expected = np.zeros((11, 13, 1))
    expected[1:10, 2:11, 0] = _window(1.5, 4)
    _check_order(total, norm, expected)
    if np.shape(total) == expected.shape:
        _check_reach(np.asarray(total)[..., 0], 5, 6, reach_y=4, reach_x=4)
        inner = np.asarray(total)[1:10, 2:11, 0]
        norm = (_line(11, 1.5, 4).sum(1)[:, np.newaxis] * _line(13, 1.5, 4).sum(1))[1:10, 2:11]
        if np.allclose(inner, expected[1:10, 2:11, 0] / norm):
            raise AssertionError("total is divided by norm already: return the two sums apart.")
        _check_bell(inner, 1.5, expected[1:10, 2:11, 0], "total around one bright pixel")
    assert_matches(total, expected, "total around one bright pixel")


@graded("gaussian_sums", points=0.5)
def test_a_flat_image_stays_flat(impl):
    "A flat image stays flat up to its corners: norm counts only pixels inside the image."
    image = np.full((9, 12, 2), 0.5)
    total, norm = impl(image, 2.0, 3)
    _compare((total, norm), image, 2.0, 3, "of a flat image")
    assert_matches(np.asarray(total) / np.asarray(norm)[..., np.newaxis], image, "total / norm of a flat image")


@graded("gaussian_sums", points=0.5)
def test_every_pixel_gets_its_sums(impl):
    "Total and norm of an image of noise, in three channels."
    image = _noise(10, 14, 3)
    _compare(impl(image, 1.3, 3), image, 1.3, 3, "of noise")


@graded("gaussian_sums", points=0.5)
def test_whole_numbers_do_not_cut_the_sums(impl):
    "An image of whole numbers gives sums with decimals."
    image = np.arange(7 * 8).reshape(7, 8, 1)
    _compare(impl(image, 1.3, 2), image, 1.3, 2, "of an image of whole numbers")


@graded("gaussian_sums", points=0.5, hidden=True)
def test_a_window_larger_than_the_image(impl):
    "A window larger than the image is clipped, whatever the shape of the image."
    for shape in ((1, 6, 3), (5, 1, 1), (3, 4, 2), (1, 1, 1)):
        image = _noise(*shape, seed=1)
        _compare(impl(image, 2.5, 9), image, 2.5, 9, f"of an image of shape {shape}")


@graded("gaussian_sums", points=0.5, hidden=True)
def test_other_radii_and_negative_values(impl):
    "Radius 0 leaves the image; negative values are averaged like others."
    image = _noise(8, 9, 2, seed=2) - 0.5
    for sigma_space, radius in ((1.0, 0), (0.6, 1), (4.0, 5)):
        _compare(impl(image, sigma_space, radius), image, sigma_space, radius, f"for radius {radius}")


@picture("gaussian_sums")
def picture_gaussian_sums(impl):
    image = _picture_image()
    total, norm = impl(image, 1.5, 5)
    target_total, target_norm = _sums(image, 1.5, 5)
    return np.asarray(total) / np.asarray(norm)[..., np.newaxis], target_total / target_norm[..., np.newaxis]


def _picture_image():
    """Discs and bars on grey, with noise; a corner is bright, so that borders show."""
    y, x = np.mgrid[:48, :64]
    image = np.full((48, 64, 3), 0.15)
    image[(y - 20) ** 2 + (x - 22) ** 2 < 120] = (0.8, 0.35, 0.1)
    image[(x > 42) & (x // 3 % 2 == 0)] = (0.2, 0.5, 0.8)
    image[:8, :10] = 0.9
    return np.clip(image + 0.2 * (_noise(48, 64, 3) - 0.5), 0, 1)


# predicted_noise: a number


@graded("predicted_noise", points=1)
def test_predicted_noise(impl):
    "The standard deviation that is left, within 5 % of what is measured."
    noise = np.random.default_rng(0).standard_normal((160, 160))
    measured = mcd.gaussian(noise, sigma_space=2.0, engine="numpy")[6:-6, 6:-6].std()
    value = float(impl)
    assert 0 < value < 1, f"the filter leaves something between all (1) and nothing (0), yours is {value:.4g}."
    slips = {
        "this is the variance; asked is the standard deviation, its square root": measured**2,
        "this is the peak of the bell; ask how independent errors add up": 1 / (8 * np.pi),
        "this is 1 / (2 sigma_space): the window has two dimensions, and a pi": 1 / 4,
    }
    for slip, wrong in slips.items():
        assert abs(value / wrong - 1) > 0.05, f"{value:.4g}: {slip}."
    direction = "small" if value < measured else "large"
    assert abs(value / measured - 1) < 0.05, f"{value:.4g} is too {direction} by more than 5 %."


# gaussian_rows(image, sigma_space, radius) -> total (h, w, c), norm (h, w), along x alone


@graded("gaussian_rows", points=0.5)
def test_an_impulse_stays_in_its_row(impl):
    "One bright pixel spreads along its row and into no other row."
    total, _ = impl(_impulse(), 1.5, 4)
    expected = np.zeros((11, 13, 1))
    expected[5, 2:11, 0] = _window(1.5, 4)[4]
    if np.shape(total) == expected.shape:
        inner = np.asarray(total)[..., 0]
        above_and_below = np.abs(inner[[4, 6], 6]).max() > 1e-9
        along = np.abs(inner[5, [5, 7]]).max() > 1e-9
        assert along or not above_and_below, "the sum runs down the columns: it must run along the rows (x, axis 1)."
        _check_reach(inner * (np.arange(11) == 5)[:, np.newaxis], 5, 6, reach_y=0, reach_x=4)
        assert not above_and_below, "the sum runs over the whole window: it must run along the row alone."
        _check_bell(inner[5, 2:11], 1.5, expected[5, 2:11, 0], "total along the row of one bright pixel")
    assert_matches(total, expected, "total around one bright pixel")


@graded("gaussian_rows", points=0.5)
def test_rows_of_noise(impl):
    "Total and norm along the rows of an image of noise."
    image = _noise(6, 15, 3, seed=3)
    _compare(impl(image, 1.7, 4), image, 1.7, 4, "along the rows of noise", rows_only=True)


@graded("gaussian_rows", points=1)
def test_two_passes_are_the_window(impl):
    "A pass along the rows, then one down the columns (the image turned over its diagonal), give the whole window."
    image = _noise(9, 12, 2, seed=4)
    total, norm = impl(image, 1.4, 4)
    again, _ = impl(np.ascontiguousarray(np.swapaxes(total, 0, 1)), 1.4, 4)
    expected_total, _ = _sums(image, 1.4, 4)
    assert_matches(np.swapaxes(again, 0, 1), expected_total, "total after both passes")
    assert_matches(norm, np.broadcast_to(_line(12, 1.4, 4).sum(1), (9, 12)), "norm after the pass along the rows")


@graded("gaussian_rows", points=1, hidden=True)
def test_rows_shorter_than_the_window(impl):
    "Rows shorter than the window, single pixels, whole numbers."
    for shape in ((4, 1, 1), (1, 5, 3), (3, 2, 2)):
        image = _noise(*shape, seed=5)
        _compare(impl(image, 3.0, 7), image, 3.0, 7, f"of an image of shape {shape}", rows_only=True)
    image = np.arange(24).reshape(4, 6, 1)
    _compare(impl(image, 1.3, 2), image, 1.3, 2, "of an image of whole numbers", rows_only=True)


@picture("gaussian_rows")
def picture_gaussian_rows(impl):
    image = _picture_image()
    total, norm = impl(image, 3.0, 9)
    target_total, target_norm = _sums(image, 3.0, 9, rows_only=True)
    return np.asarray(total) / np.asarray(norm)[..., np.newaxis], target_total / target_norm[..., np.newaxis]


# predicted_order: three names of scenes


@graded("predicted_order", points=1)
def test_predicted_order(impl):
    "The three scenes, from the one that wants the smallest sigma_space to the one that wants the largest."
    names = [str(name) for name in impl]
    assert sorted(names) == sorted(BEST_SIGMA), (
        f"the names are {', '.join(sorted(BEST_SIGMA))}, each once; got {names}."
    )
    order = sorted(BEST_SIGMA, key=BEST_SIGMA.get)
    assert names != order[::-1], (
        "this is the reverse order: the best sigma_space grows with noise and falls with detail."
    )
    assert names[0] == order[0], (
        f"{names[0]} does not want the smallest sigma_space. Where is there little noise to take away, and much detail to "
        f"lose?"
    )
    assert names == order, f"{names[0]} is right; compare the noise of the other two."


# hard_image(height, width) -> (height, width) in [0, 1]


def _check_hard(impl, height, width, deviation, seed):
    image = _array(impl(height, width))
    assert image.shape == (height, width), f"shape ({height}, {width}) is needed, yours is {image.shape}."
    assert np.isfinite(image).all(), "there are NaN or infinite values."
    low, high = image.min(), image.max()
    assert 0 <= low <= high <= 1, f"radiance between 0 and 1 is asked for, yours runs from {low:.4g} to {high:.4g}."
    noisy = image + deviation * np.random.default_rng(seed).standard_normal(image.shape)
    before = mcd.mse(noisy, image)
    for sigma_space in (0.5, 0.7, 1.0, 2.0, 4.0):
        after = mcd.mse(mcd.gaussian(noisy, sigma_space=sigma_space, engine="numpy"), image)
        assert after > before, (
            f"at sigma_space {sigma_space:g} the Gaussian still helps: the mean squared error falls from {before:.4f} to "
            f"{after:.4f}. What does averaging neighbours destroy most?"
        )


@graded("hard_image", points=1)
def test_every_gaussian_is_worse_than_none(impl):
    "With noise of standard deviation 0.1, each Gaussian from sigma_space 0.5 to 4 makes the error larger."
    _check_hard(impl, 48, 64, 0.1, seed=0)


@graded("hard_image", points=1, hidden=True)
def test_also_for_other_sizes_and_more_noise(impl):
    "Also for other sizes, and with noise of standard deviation 0.2."
    _check_hard(impl, 33, 50, 0.2, seed=1)
    _check_hard(impl, 64, 21, 0.1, seed=2)


# stubborn_noise(height, width, seed) -> (height, width), mean 0, standard deviation 1


def _stubborn(impl, height, width, seed):
    noise = _array(impl(height, width, seed))
    assert noise.shape == (height, width), f"shape ({height}, {width}) is needed, yours is {noise.shape}."
    assert np.isfinite(noise).all(), "there are NaN or infinite values."
    mean, deviation = noise.mean(), noise.std()
    assert abs(mean) < 0.01, f"the mean must be 0, yours is {mean:.4g}: subtract it."
    assert abs(deviation - 1) < 0.01, f"the standard deviation must be 1, yours is {deviation:.4g}: divide by it."
    return noise


def _check_left(noise):
    left = mcd.gaussian(noise, sigma_space=2.0, engine="numpy").var()
    assert left > 0.5, (
        f"the Gaussian leaves {left:.3f} of the variance; more than 0.5 is asked for. White noise leaves 0.02, because its "
        f"pixels are independent: let neighbours err alike."
    )


@graded("stubborn_noise", points=1)
def test_the_gaussian_leaves_more_than_half(impl):
    "Noise of mean 0 and variance 1, of which a Gaussian of sigma_space 2 leaves more than half."
    _check_left(_stubborn(impl, 64, 80, 0))


@graded("stubborn_noise", points=0.5)
def test_it_is_random(impl):
    "Two seeds give two different noises; one seed gives the same again."
    first, second, again = (_stubborn(impl, 64, 80, seed) for seed in (1, 2, 1))
    assert np.array_equal(first, again), "the same seed must give the same noise: np.random.default_rng(seed)."
    likeness = float(np.mean(first * second))
    assert abs(likeness) < 0.6, f"two seeds give nearly the same noise (correlation {likeness:.2f}): use the seed."


@graded("stubborn_noise", points=0.5, hidden=True)
def test_other_sizes_of_noise(impl):
    "The same for other sizes."
    for height, width, seed in ((40, 40, 5), (96, 50, 6)):
        _check_left(_stubborn(impl, height, width, seed))
