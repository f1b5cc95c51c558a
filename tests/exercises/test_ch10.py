"""The exercises of chapter 10, speed against accuracy, stability, no more model than needed: what holds for a right answer."""

import numpy as np

from mcdenoise.classroom import Finding, as_numbers, as_parts, assert_matches, graded, name_mistake, picture


def _one_number(found, needed):
    """The answer as one number, or the sentence that says what is needed."""
    value = as_numbers(found)
    assert value is not None, needed
    assert value.shape == (), needed
    return float(value)


# --- pareto_front(seconds, errors)


def _front(seconds, errors):
    """Point by point: does another one dominate?"""
    points = list(zip(seconds.tolist(), errors.tolist(), strict=True))
    return np.array([not any(a <= s and b <= e and (a, b) != (s, e) for a, b in points) for s, e in points])


def _chart():
    """Seven points: four on the front, one behind it, two that tie with a point of it."""
    seconds = np.array([4.0, 2.0, 1.0, 5.0, 3.0, 2.0, 3.5])
    return seconds, np.array([0.10, 0.40, 0.50, 0.10, 0.35, 0.30, 0.29])


@graded("pareto_front", points=0.5)
def test_who_is_on_the_front(impl):
    "True where no other point is at most as slow and at most as wrong, and better in one of the two; in the order given."
    seconds, errors = _chart()
    expected = _front(seconds, errors)
    order = np.argsort(seconds, kind="stable")
    strict = [not np.any((seconds < s) & (errors < e)) for s, e in zip(seconds, errors, strict=True)]
    mistakes = {
        "everybody but the front: that is who is dominated": ~expected,
        "nobody is on the front: does each point dominate itself? It is at most as slow as itself, but not better": 0
        * expected,
        "a point that ties in one and is worse in the other is dominated: better in one of the two is enough": strict,
        "that is the order by time, not the order in which the points came": expected[order],
        "only the corners of the convex hull: a point between two of them may stand back from their line and still be beaten by "
        "nobody": expected & (errors != 0.29),
        "only the fastest and the most accurate: there may be points between them": np.isin(np.arange(7), (0, 2)),
        "points count as beaten by whoever is better in one of the two: it must be no worse in the other": np.zeros(7),
        "that is the front of the slowest and most wrong": _front(-seconds, -errors),
    }
    found, what = impl(seconds, errors), "the front of seven points"
    assert not np.array_equal(as_numbers(found), np.flatnonzero(expected)), (
        f"{what}: numbers of points came back; True or False is needed for each of the seven."
    )
    values = as_numbers(found)
    assert np.shape(values) != (7,) or np.sum(values) != 1, (
        f"{what}: only one point came back: on the front there are all that nobody beats in both."
    )
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


@graded("pareto_front", points=0.5)
def test_equals_do_not_beat_each_other(impl):
    "Two points in the same place are both on the front, or neither is; a point alone is."
    seconds, errors = np.array([2.0, 1.0, 2.0, 3.0, 3.0]), np.array([0.2, 0.4, 0.2, 0.3, 0.3])
    expected, what = np.array([True, True, True, False, False]), "two pairs in the same place"
    mistakes = {
        "only the first of two equals is there: neither beats the other": [True, True, False, False, False],
        "only the last of two equals is there: neither beats the other": [False, True, True, False, False],
        "equals are left out: neither beats the other": [False, True, False, False, False],
    }
    name_mistake(impl(seconds, errors), expected, mistakes, what)
    assert_matches(impl(seconds, errors), expected, what)
    assert_matches(impl(seconds[:1], errors[:1]), np.array([True]), "a point alone")


@graded("pareto_front", points=0.5, hidden=True)
def test_fronts_of_any_points(impl):
    "Any number of points, with and without ties; the same whatever the units of time."
    rng = np.random.default_rng(2)
    for n, levels in ((2, 2), (30, 5), (200, 40)):
        seconds, errors = rng.integers(1, 1 + levels, n) / 8, rng.integers(1, 1 + levels, n) / 64
        expected = _front(seconds, errors)
        assert_matches(impl(seconds, errors), expected, f"the front of {n} points")
        assert_matches(impl(1000 * seconds, errors), expected, f"the front of {n} points, in milliseconds")


# --- equal_error_spp(error, spp, mc_errors)

SPP, MC_ERRORS = np.array([4.0, 16.0, 64.0]), np.array([0.16, 0.04, 0.02])  # slopes -1 and -1/2


def _assert_equal_error(impl, error, expected, mistakes, what):
    found = impl(error, SPP.copy(), MC_ERRORS.copy())
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


@graded("equal_error_spp", points=0.75)
def test_between_two_measured_spp(impl):
    "On the straight line through two measured points, in logarithms of both."
    error = 0.08
    mistakes = {
        "a straight line without logarithms": 12.0,
        "the logarithm of spp is there, that of the error is missing": 4 * 4 ** (2 / 3),
        "the logarithm of the error is there, that of spp is missing": 10.0,
        "that is log(spp): exp is missing": np.log(8),
        "that is log2(spp): 2 to that power is missing": 3.0,
        "that is log10(spp): 10 to that power is missing": np.log10(8),
        "the next measured spp: between two of them there is a line": 16.0,
        "the measured spp before: between two of them there is a line": 4.0,
        "np.interp wants its x values ascending, and errors fall: turn both around": float(
            np.exp(np.interp(np.log(error), np.log(MC_ERRORS), np.log(SPP)))
        ),
        "one line through all points: the measured curve bends": float(
            np.exp(np.polyval(np.polyfit(np.log(MC_ERRORS), np.log(SPP), 1), np.log(error)))
        ),
        "not as many samples, but how many times as many as at the first point": 2.0,
    }
    _assert_equal_error(impl, error, 8.0, mistakes, "error 0.08 on a curve from 0.16 at 4 spp to 0.04 at 16 spp")
    what = "error 0.02 x sqrt(2) on a curve from 0.04 at 16 spp to 0.02 at 64 spp"
    error = 0.02 * np.sqrt(2)
    mistakes = {
        "a slope of -1 is taken: between two points it is the measured one": 16 * 0.04 / error,
        "a slope of -1 is taken, from the first point on: between two points it is the measured one": 0.64 / error,
        "a slope of -1 is taken, from the last point back: between two points it is the measured one": 1.28 / error,
    }
    _assert_equal_error(impl, error, 32.0, mistakes, what)


@graded("equal_error_spp", points=0.25)
def test_outside_the_measured_spp(impl):
    "Beyond the ends error x spp is that of the end: Monte Carlo needs twice the samples for half the error. Not rounded."
    what = "error 0.005, four times smaller than at 64 spp"
    mistakes = {
        "it stops at the largest measured spp": 64.0,
        "the last line goes on: outside the slope is -1": 1024.0,
        "error x spp is that of the first point: the last one is nearer": 128.0,
        "Monte Carlo's root mean square error goes with the root of spp; this error is squared": 128.0,
        "infinite: outside the curve goes on with slope -1": np.inf,
        "NaN: outside the curve goes on with slope -1": np.nan,
    }
    _assert_equal_error(impl, 0.005, 256.0, mistakes, what)
    what = "error 0.48, three times larger than at 4 spp"
    mistakes = {
        "it stops at the smallest measured spp": 4.0,
        "rounded up: a part of a sample counts too": 2.0,
        "rounded: a part of a sample counts too": 1.0,
        "error x spp is that of the last point: the first one is nearer": 1.28 / 0.48,
    }
    _assert_equal_error(impl, 0.48, 4 / 3, mistakes, what)


@graded("equal_error_spp", points=0.5, hidden=True)
def test_equal_error_on_any_curve(impl):
    "At the measured points their spp; a power law gives its inverse everywhere; one point alone has the slope -1."
    rng = np.random.default_rng(4)
    for slope in (-1.3, -1.0, -0.4):
        spp = np.cumsum(rng.integers(1, 9, 5)).astype(float)
        errors = 0.3 * spp**slope
        for n, error in zip(spp, errors, strict=True):
            assert_matches(impl(float(error), spp, errors), n, f"a measured error, slope {slope}")
        inside = float(np.sqrt(spp[1] * spp[2]))
        assert_matches(impl(0.3 * inside**slope, spp, errors), inside, f"between two points, slope {slope}")
        assert_matches(
            impl(float(errors[-1]) / 8, spp, errors), 8 * spp[-1], f"an error beyond the last, slope {slope}"
        )
        assert_matches(impl(float(errors[0]) * 5, spp, errors), spp[0] / 5, f"an error before the first, slope {slope}")
    assert_matches(impl(0.02, np.array([8.0]), np.array([0.06])), 24.0, "one point alone")


# --- break_even_spp


@graded("break_even_spp", points=1)
def test_where_plain_monte_carlo_catches_up(impl):
    "The n at which squared bias + variance / n of the filter equals the variance / n of Monte Carlo."
    n = _one_number(impl, "one number is needed, such as 10.")
    bias_squared, filter_variance, variance = 0.002, 0.04, 0.2
    hints = {
        variance / bias_squared: "there Monte Carlo is down to the squared bias. But the filter has some noise too",
        (variance + filter_variance) / bias_squared: "the variances are added: on which side does each of them stand?",
        filter_variance / bias_squared: "there the filter's own variance is down to its squared bias",
        variance
        / filter_variance: "that is how many times less noise the filter has, as long as nobody asks for its bias",
        (variance - filter_variance) / np.sqrt(bias_squared): "the bias is squared already",
        (variance - filter_variance) / bias_squared**2: "the bias is squared already",
        bias_squared / (variance - filter_variance): "that is 1 / n",
    }
    for value, words in hints.items():
        assert not np.isclose(n, value, rtol=0.01), f"not {n:g}: {words}."
    expected = (variance - filter_variance) / bias_squared
    side = "filter" if 0 < n < expected else "plain Monte Carlo"
    assert np.isclose(n, expected, rtol=0.005), (
        f"not {n:g}: there the {side} is better. Write both errors down, as equal."
    )


# --- new_method(radiance, albedo)

SHARE = 0.3  # of the relMSE of the noisy image


def _paints(seed, height=40, width=48, spp=8):
    """A wall of tiles under uneven light with the border of a shadow, some tiles black: samples, albedo and truth."""
    rng = np.random.default_rng(seed)
    y, x = np.indices((height, width))
    tiles = rng.uniform(0.1, 0.9, (height // 8 + 1, width // 8 + 1, 3))
    tiles[rng.random(tiles.shape[:2]) < 0.1] = 0
    light = (0.4 + 0.8 * x / width) * np.where(y + x // 2 > 0.8 * height, 0.35, 1.0)
    albedo = tiles[y // 8, x // 8]
    truth = albedo * light[..., np.newaxis]
    return truth[:, :, np.newaxis] * rng.gamma(1.0, 1.0, (height, width, spp, 1)), albedo, truth


def _relmse(image, truth):
    return float(np.mean((image - truth) ** 2 / (truth**2 + 0.01)))


def _assert_is_good(impl, scene, what):
    radiance, albedo, truth = scene
    found, noisy = impl(radiance.copy(), albedo.copy()), radiance.mean(axis=2)
    values = as_numbers(found)
    if values is None or values.shape != truth.shape:
        assert_matches(found, truth, what)
    black = np.all(albedo == 0, axis=-1)
    bad = ~np.isfinite(values).all(axis=-1)
    assert not bad.any(), f"{what}: {int(bad.sum())} pixels are NaN or infinite" + (
        ", where the albedo is 0: what do you divide by there?" if bad[black].any() else "."
    )
    share = _relmse(values, truth) / _relmse(noisy, truth)
    if share <= SHARE:
        return
    edges = np.abs(np.diff(albedo, axis=1)).max(axis=-1) > 0
    near = np.pad(edges, ((0, 0), (1, 0))) | np.pad(edges, ((0, 0), (0, 1)))
    wrong = (values - truth) ** 2 / (truth**2 + 0.01)
    if np.allclose(values, noisy):
        hint = "that is the noisy image itself"
    elif values.mean() > 2 * truth.mean():
        hint = "it is much brighter than it should be: is the mean over the samples missing?"
    elif wrong[near].mean() > 2 * wrong[~near].mean():
        hint = "most of the error lies where two paints meet. The albedo is free of noise: what can you do with it?"
    else:
        hint = "it is spread over the image: more neighbours make less noise"
    raise Finding(
        f"{what}: relMSE {_relmse(values, truth):.4f}, {share:.2f} times that of the noisy image; at most {SHARE:g} times is "
        f"needed. {hint[0].upper() + hint[1:]}."
    )


@graded("new_method", points=1.5)
def test_the_new_method_is_accurate(impl):
    "On a wall of tiles, relMSE is at most 0.3 times that of the noisy image; black tiles stay finite."
    _assert_is_good(impl, _paints(5), "40 x 48 pixels, 8 spp")


@graded("new_method", points=0.5, hidden=True)
def test_the_new_method_on_other_walls(impl):
    "Other paints, sizes and spp."
    for seed, height, width, spp in ((6, 32, 32, 4), (7, 64, 40, 8)):
        _assert_is_good(impl, _paints(seed, height, width, spp), f"{height} x {width} pixels, {spp} spp")


@picture("new_method")
def picture_of_the_new_method(impl):
    radiance, albedo, truth = _paints(5)
    return impl(radiance, albedo), truth


# --- bias_and_variance(images, truth)

BOTH = ("bias_squared", "variance")


def _two_sums(images, truth):
    """Squared bias and variance, pixel by pixel."""
    bias_squared, variance = np.zeros(truth.shape), np.zeros(truth.shape)
    for place in np.ndindex(truth.shape):
        values = [float(image[place]) for image in images]
        mean = sum(values) / len(values)
        variance[place] = sum((one - mean) ** 2 for one in values) / (len(values) - 1)
        bias_squared[place] = (mean - truth[place]) ** 2 - variance[place] / len(values)
    return bias_squared, variance


def _three_images():
    return np.array([[[1.0, 2.0], [0.5, 3.0]], [[2.0, 2.5], [0.1, 3.3]], [[4.5, 3.0], [0.3, 3.9]]]), np.array(
        [[1.0, 2.6], [0.9, 2.0]]
    )


@graded("bias_and_variance", points=0.5)
def test_variance_over_the_seeds(impl):
    "variance: of each pixel, over the images, divided by n - 1."
    images, truth = _three_images()
    found, expected = as_parts(impl(images, truth), BOTH)[1], _two_sums(images, truth)[1]
    away = images - truth
    mistakes = {
        "divided by n: the mean is estimated from the same images, so n - 1": expected * 2 / 3,
        "not divided by n - 1": 2 * expected,
        "that is the variance of the mean of all images: of one image it is n times as much": expected / 3,
        "that is the standard deviation: square it": np.sqrt(expected),
        "from the truth instead of the mean: that is the whole error": np.mean(away**2, axis=0),
        "from the truth instead of the mean: that is the whole error, and divided by n - 1": np.sum(away**2, axis=0)
        / 2,
        "the variance over the pixels of each image: over the images of each pixel": images.var(axis=(1, 2), ddof=1),
        "one number for all images and pixels: each pixel has its own": images.var(ddof=1),
        "the mean over the pixels: each pixel has its own": expected.mean(),
        "that is bias_squared: the order is bias_squared, variance": _two_sums(images, truth)[0],
    }
    name_mistake(found, expected, mistakes, "variance from three images")
    assert_matches(found, expected, "variance from three images")


@graded("bias_and_variance", points=0.5)
def test_squared_bias_is_corrected(impl):
    "bias_squared: (mean of the images - truth)^2 holds noise, on average the variance of that mean; it is taken off."
    images, truth = _three_images()
    found = as_parts(impl(images, truth), BOTH)[0]
    expected, variance = _two_sums(images, truth)
    plain = expected + variance / 3
    mistakes = {
        "nothing is taken off: with three images their mean is still noisy": plain,
        "the whole variance is taken off: the mean of n images has less": plain - variance,
        "the variance of the mean is added: take it off": plain + variance / 3,
        "divided by n - 1 once more: the mean of n images has variance / n": plain - variance / 2,
        "the variance that was divided by n is used: n - 1": plain - variance * 2 / 9,
        "set to 0 where it is negative: then the mean over pixels is too large": np.maximum(expected, 0),
        "its size without the sign: an estimate may be negative": np.abs(expected),
        "that is the bias, not its square": images.mean(axis=0) - truth,
        "that is the whole mean squared error": np.mean((images - truth) ** 2, axis=0),
        "the mean over the pixels: each pixel has its own": expected.mean(),
        "that is the variance: the order is bias_squared, variance": variance,
    }
    name_mistake(found, expected, mistakes, "bias_squared from three images")
    assert_matches(found, expected, "bias_squared from three images")


@graded("bias_and_variance", points=0.5, hidden=True)
def test_bias_and_variance_of_any_images(impl):
    "Any number and shape of images; added light changes the bias alone; both together are the expected error."
    rng = np.random.default_rng(8)
    for n, shape in ((2, (1, 1)), (5, (4, 3, 3)), (16, (7,))):
        images, truth = rng.gamma(2.0, 0.5, (n, *shape)), rng.random(shape)
        found = as_parts(impl(images, truth), BOTH)
        for one, right, name in zip(found, _two_sums(images, truth), BOTH, strict=True):
            assert_matches(one, right, f"{name} of {n} images of shape {shape}", atol=1e-9)
        error = np.mean((images - truth) ** 2, axis=0)
        assert_matches(found[0] + found[1], error, f"bias_squared + variance of {n} images", atol=1e-9)


# --- one_pixel(noisy, truth, sigma_space, factor)

ROOM = 1.2  # times the factor: the most that is allowed


def _blurred(image, sigma):
    """The image under a Gaussian over all pixels, normalised at borders."""
    for axis in (0, 1):
        place = np.arange(image.shape[axis])
        bell = np.exp(-((place[:, np.newaxis] - place) ** 2) / (2 * sigma**2))
        image = np.moveaxis(np.tensordot(bell / bell.sum(axis=1, keepdims=True), image, (1, axis)), 0, axis)
    return image


def _wall(seed, height, width):
    """A grey wall with a shadow, and the same with noise: noisy and truth."""
    rng = np.random.default_rng(seed)
    truth = np.where(np.arange(width) > width // 2, 0.3, 0.8) * np.ones((height, 1))
    return np.maximum(truth + 0.1 * rng.normal(size=truth.shape), 0), truth


def _assert_breaks(impl, seed, size, sigma, factor):
    noisy, truth = _wall(seed, *size)
    what = f"{size[0]} x {size[1]} pixels, sigma_space {sigma:g}, factor {factor:g}"
    found = impl(noisy.copy(), truth.copy(), sigma, factor)
    values = as_numbers(found)
    if values is None or values.shape != noisy.shape:
        assert_matches(found, noisy, f"{what}: the image")
    assert np.isfinite(values).all(), f"{what}: the image must be finite."
    changed = np.abs(values - noisy) > 1e-12
    assert changed.any(), f"{what}: the image is the noisy one, nothing is changed."
    assert changed.sum() == 1, f"{what}: {int(changed.sum())} pixels differ from the noisy image, only one may."
    y, x = np.argwhere(changed)[0]
    assert values[y, x] >= 0, f"{what}: the pixel is {values[y, x]:.3g}, but radiance is not negative."
    errors = [np.mean((_blurred(one, sigma) - truth) ** 2) for one in (noisy, values)]
    grows = errors[1] / errors[0]
    added = values[y, x] - noisy[y, x]
    told = f"{what}: with {added:+.3g} in pixel ({y}, {x}) the error grows by a factor of {grows:.4g}"
    assert grows >= factor, f"{told}, at least {factor:g} is needed. The damage grows with the square of what you add."
    assert grows <= ROOM * factor, (
        f"{told}, at most {ROOM * factor:.4g} is allowed: find out how much is needed. What one pixel adds to the filtered image "
        f"is a bell; its squares sum to about 1 / (4 pi sigma^2) of the square of what you add."
    )


@graded("one_pixel", points=1)
def test_one_pixel_breaks_the_gaussian(impl):
    "One pixel is changed, and the mean squared error of the filtered image grows by the factor, up to 1.2 times that."
    _assert_breaks(impl, 9, (32, 32), 1.5, 50.0)


@graded("one_pixel", points=0.5, hidden=True)
def test_one_pixel_of_any_image(impl):
    "Other sizes, bandwidths and factors."
    for seed, size, sigma, factor in ((10, (24, 40), 1.0, 10.0), (11, (48, 32), 3.0, 1000.0)):
        _assert_breaks(impl, seed, size, sigma, factor)


# --- median_of_means(radiance, groups)


def _seven():
    """Two pixels of seven samples; the second has one that is far off."""
    grey = np.array([[1.0, 4.0, 5.0, 7.0, 8.0, 3.0, 6.0], [0.2, 0.3, 90.0, 0.1, 0.4, 0.2, 0.6]])
    return (grey[..., np.newaxis] * np.array([1.0, 0.5, 2.0])).reshape(1, 2, 7, 3)


def _cut(spp, groups):
    """Where the groups begin and end."""
    sizes = [spp // groups + (k < spp % groups) for k in range(groups)]
    return [(sum(sizes[:k]), sum(sizes[: k + 1])) for k in range(groups)]


def _median_of(radiance, parts):
    """The median of the means of some parts of the samples."""
    means = np.sort([radiance[:, :, part].mean(axis=2) for part in parts], axis=0)
    return (means[(len(means) - 1) // 2] + means[len(means) // 2]) / 2


@graded("median_of_means", points=0.5)
def test_median_of_the_means_of_groups(impl):
    "Seven samples in three groups: of 3, 2 and 2, in their order; the mean of each, and of those the median."
    radiance = _seven()
    parts = [slice(*ends) for ends in _cut(7, 3)]
    expected, what = _median_of(radiance, parts), "seven samples in three groups"
    means = [radiance[:, :, part].mean(axis=2) for part in parts]
    mistakes = {
        "the mean of all samples": radiance.mean(axis=2),
        "the median of all samples: first the mean of each group": np.median(radiance, axis=2),
        "the mean of the groups' medians: it is the other way round": np.mean(
            [np.median(radiance[:, :, part], axis=2) for part in parts], axis=0
        ),
        "the mean of the groups' means: their median is asked for": np.mean(means, axis=0),
        "the median of the groups' sums: take their means": np.median(
            [radiance[:, :, part].sum(axis=2) for part in parts], axis=0
        ),
        "every third sample is in one group: the groups are cut in the order of the samples": _median_of(
            radiance, [slice(k, None, 3) for k in range(3)]
        ),
        "the larger group comes last: it comes first": _median_of(radiance, [slice(0, 2), slice(2, 4), slice(4, 7)]),
        "the last sample is left out: it belongs to a group too": _median_of(
            radiance, [slice(0, 2), slice(2, 4), slice(4, 6)]
        ),
        "groups of three samples: there must be three groups": _median_of(
            radiance, [slice(0, 3), slice(3, 6), slice(6, 7)]
        ),
        "the smallest of the means": np.min(means, axis=0),
        "the largest of the means": np.max(means, axis=0),
        "the mean over the channels: each has a median of its own": np.repeat(
            expected.mean(axis=-1, keepdims=True), 3, axis=-1
        ),
    }
    found = impl(radiance.copy(), 3)
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


@graded("median_of_means", points=0.5)
def test_one_group_and_a_group_for_each_sample(impl):
    "One group is the mean, a group for each sample the median; the median of an even number lies between the middle two."
    radiance = _seven()
    assert_matches(impl(radiance.copy(), 1), radiance.mean(axis=2), "one group")
    assert_matches(impl(radiance.copy(), 7), np.median(radiance, axis=2), "seven groups")
    parts, what = [slice(*ends) for ends in _cut(7, 4)], "seven samples in four groups"
    means = np.sort([radiance[:, :, part].mean(axis=2) for part in parts], axis=0)
    expected = (means[1] + means[2]) / 2
    mistakes = {
        "the lower one of the middle two: halfway between them": means[1],
        "the upper one of the middle two: halfway between them": means[2],
    }
    found = impl(radiance.copy(), 4)
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


@graded("median_of_means", points=0.5, hidden=True)
def test_median_of_means_of_any_samples(impl):
    "Any image, spp and number of groups; bad samples in less than half of the groups do not get through."
    rng = np.random.default_rng(12)
    for height, width, spp, groups in ((3, 2, 8, 3), (1, 4, 9, 9), (2, 5, 16, 5), (4, 3, 6, 2)):
        radiance = rng.gamma(1.0, 1.0, (height, width, spp, 3))
        expected = _median_of(radiance, [slice(*ends) for ends in _cut(spp, groups)])
        assert_matches(impl(radiance, groups), expected, f"{spp} samples in {groups} groups")
    radiance[:, :, 0] = 1e12
    low, high = radiance[:, :, 1:].min(axis=2), radiance[:, :, 1:].max(axis=2)
    found = np.asarray(impl(radiance, 3))
    assert np.all((low <= found) & (found <= high)), "a bad sample in one of three groups got through."


# --- median_limits


@graded("median_limits", points=1)
def test_what_the_median_of_means_bears_and_costs(impl):
    "Bad samples that are borne in 1, 4, 5 and 16 groups of 16 samples, and what is left of a small lamp."
    given = (3, 3, 3, 3, 1.0)
    values = as_numbers(impl)
    assert np.shape(values) == (5,), f"5 numbers are needed, as in {given}."
    for groups, count in zip((1, 4, 5, 16), values, strict=False):
        middle = "the middle one" if groups % 2 else "the mean of the middle two"
        borne = (groups - 1) // 2
        if groups == 1:
            hint = "one group is the mean, and a single bad sample is enough to move the mean as far as it likes"
        elif count > borne:
            hint = (
                f"put that many bad samples into as many groups. The median of {groups} numbers is {middle}: is a bad one "
                f"among them?"
            )
        else:
            hint = f"the median of {groups} numbers is {middle}: how many may be spoiled before it is touched?"
        assert count == borne, f"{groups} group{'s' * (groups > 1)}: not {count:g}: {hint}."
    lamp = values[4]
    hints = {
        1.0: "that is the mean, the true value",
        16.0: "that is the sample with the lamp",
        4.0: "that is one of the four means",
    }
    assert lamp == 0, (
        f"the pixel with the lamp: not {lamp:g}: {hints.get(float(lamp), 'write down the four means')}. What is their median?"
    )


# --- permutation_p_value(observed, permuted)


@graded("permutation_p_value", points=0.5)
def test_p_value_of_nine_shuffles(impl):
    "The share of the ten orders, nine shuffled and the observed one, that do at least as well as the observed one."
    permuted = np.array([0.1, 0.5, 0.2, 0.7, 0.3, 0.4, 0.5, 0.2, 0.05])
    mistakes = {
        "the observed order is not counted: it is one of the ten": 3 / 9,
        "the observed order is counted above the line, but not below": 4 / 9,
        "the observed order is counted below the line, but not above: it does as well as itself": 3 / 10,
        "those that do exactly as well count too: at least, not more": 2 / 10,
        "those that do exactly as well count too, and the observed order is one of ten": 1 / 9,
        "that is the share of those that do worse": 6 / 9,
        "that is 1 - p": 6 / 10,
        "the share of those that do worse or as well": 9 / 10,
        "twice that: chance has to be beaten on one side only": 8 / 10,
        "that is a number of orders, not a share": 4.0,
        "that is a number of shuffles, not a share": 3.0,
    }
    found = impl(0.5, permuted)
    name_mistake(found, 0.4, mistakes, "p, observed 0.5")
    assert_matches(found, 0.4, "p, observed 0.5")
    found, what = impl(0.9, permuted), "p where no shuffle does as well"
    assert as_numbers(found) is None or np.any(as_numbers(found) != 0), (
        f"{what}: 0 would say that chance can never do it, and nine shuffles cannot know that. The observed order is one of ten."
    )
    assert_matches(found, 0.1, what)


@graded("permutation_p_value", points=0.5, hidden=True)
def test_p_values_of_any_shuffles(impl):
    "Any number of shuffles; never 0, 1 if all do as well; under chance alone each value is equally likely."
    rng = np.random.default_rng(14)
    for n in (1, 19, 500):
        permuted = rng.integers(0, 8, n) / 8
        for observed in (0.0, 0.5, 2.0):
            expected = (1 + sum(float(one) >= observed for one in permuted)) / (n + 1)
            assert_matches(impl(observed, permuted), expected, f"p of {n} shuffles, observed {observed:g}")


# --- error_against_other(filtered, other, variance_of_other)


@graded("error_against_other", points=0.5)
def test_the_variance_of_the_other_is_taken_off(impl):
    "Mean over pixels and channels of (filtered - other)^2, less what the noise of the other image puts into it."
    filtered, other = np.array([[[1.0, 2.0, 3.0]], [[0.5, 1.5, 2.5]]]), np.array([[[2.0, 4.0, 3.5]], [[0.0, 3.0, 1.5]]])
    variance = np.array([[[0.4, 1.0, 0.1]], [[0.2, 0.9, 0.4]]])
    square, expected = float(np.mean((filtered - other) ** 2)), 8.75 / 6 - 0.5
    mistakes = {
        "nothing is taken off: the other image has noise of its own": square,
        "the variance is added: take it off": square + 0.5,
        "half of the variance is taken off": square - 0.25,
        "twice the variance is taken off": square - 1.0,
        "its standard deviation is taken off: the variance": square - float(np.mean(np.sqrt(variance))),
        "its square is taken off: the variance itself": square - float(np.mean(variance**2)),
        "that is the root of it: the error is squared": float(np.sqrt(expected)),
        "the sum over pixels and channels: their mean": 6 * expected,
        "the sum over the channels: the mean over pixels and channels": 3 * expected,
        "the squared difference of the means: square first, then take the mean": float(np.mean(filtered - other)) ** 2
        - 0.5,
        "the size of the difference: its square": float(np.mean(np.abs(filtered - other))) - 0.5,
        "divided by the variance: take it off": float(np.mean((filtered - other) ** 2 / variance)),
        "a map: one number, the mean over pixels and channels": (filtered - other) ** 2 - variance,
    }
    found = impl(filtered, other, variance)
    name_mistake(found, expected, mistakes, "the error of six numbers")
    assert_matches(found, expected, "the error of six numbers")


@graded("error_against_other", points=0.5)
def test_an_estimate_may_be_negative(impl):
    "The estimate is right on average, so where the true error is small it is sometimes below 0: nothing is cut off."
    far, what = np.zeros((1, 2, 3)), "two pixels, of which one has a much noisier other"
    other = np.array([[[1.0, 1.0, 1.0], [3.0, 3.0, 3.0]]])
    variance = np.array([[[2.0, 2.0, 2.0], [1.0, 1.0, 1.0]]])
    name_mistake(impl(far, other, variance), 3.5, {"each pixel is cut off at 0: then the mean is too large": 4.0}, what)
    assert_matches(impl(far, other, variance), 3.5, what)
    same = np.ones((2, 2, 3))
    found, what = impl(same, same.copy(), 0.3 * same), "filtered equals other, variance 0.3"
    assert as_numbers(found) is None or np.any(as_numbers(found) < 0), (
        f"{what}: it is below 0. Do not cut it off or take its size: estimates that are never negative are too large on average."
    )
    assert_matches(found, -0.3, what)


@graded("error_against_other", points=0.5, hidden=True)
def test_on_average_it_is_the_true_error(impl):
    "Over many noisy others of any shape the estimates agree with the true error, within four standard errors."
    rng = np.random.default_rng(15)
    for shape in ((4, 3, 3), (5, 5)):
        truth, filtered, deviation = rng.random(shape), rng.random(shape), rng.uniform(0.2, 1.0, shape)
        estimates = [
            float(impl(filtered, truth + deviation * rng.normal(size=shape), deviation**2)) for _ in range(200)
        ]
        away = abs(np.mean(estimates) - np.mean((filtered - truth) ** 2))
        assert away < 4 * np.std(estimates) / np.sqrt(200), (
            f"shape {shape}: off by {away:.3g} on average of 200 estimates."
        )


# --- smallest_layout

LAYOUTS = {  # what the filter is given -> relMSE of five seeds, in thousandths
    (): (40.1, 38.2, 41.5, 39.0, 40.7),
    ("albedo",): (10.3, 11.5, 9.9, 10.7, 11.1),
    ("albedo", "light_u", "light_v"): (10.3, 9.8, 11.1, 9.7, 10.6),
    ("albedo", "light_u", "light_v", "shading_normal"): (9.2, 10.9, 9.7, 10.8, 9.4),
    ("albedo", "lens_u", "lens_v", "light_u", "light_v"): (10.4, 9.9, 11.1, 9.8, 10.5),
    ("albedo", "lens_u", "lens_v", "light_u", "light_v", "shading_normal"): (9.3, 10.9, 9.8, 10.9, 9.4),
}


def _means():
    """Mean of each layout, the best layout, and one standard error of the best."""
    means = {names: float(np.mean(errors)) for names, errors in LAYOUTS.items()}
    best = min(means, key=means.get)
    return means, best, float(np.std(LAYOUTS[best], ddof=1) / np.sqrt(5))


PAIR = 'a pair is needed, names and per cent, as in (("lens_u", "lens_v"), 12.5).'


def _pair(found):
    assert isinstance(found, (tuple, list)), PAIR
    assert len(found) == 2, PAIR
    return found


def _words(names):
    return ", ".join(names) or "nothing"


@graded("smallest_layout", points=1)
def test_the_smallest_layout_within_one_standard_error(impl):
    "The layout with the fewest names whose mean error is within one standard error of the best."
    names = _pair(impl)[0]
    names = (names,) if isinstance(names, str) else names
    assert isinstance(names, (tuple, list)), PAIR
    assert all(isinstance(one, str) for one in names), PAIR
    names = tuple(sorted(names))
    assert names in LAYOUTS, f"{_words(names)}: there is no such layout in the table."
    means, best, error = _means()
    limit = means[best] + error
    fits = [one for one in LAYOUTS if means[one] <= limit]
    right = min(fits, key=len)
    told = f"not {_words(names)}: its mean is {means[names]:.2f}"
    assert names in fits, f"{told}, above {limit:.2f}, the best mean and one standard error. " + (
        "A standard error is the deviation of the seeds divided by the root of their number."
        if means[names] <= means[best] + error * np.sqrt(5)
        else "A small model is no use if it is clearly worse."
    )
    assert names == right, f"{told}, within one standard error of the best; so is that of a layout with fewer names."


@graded("smallest_layout", points=0.5)
def test_what_the_smallest_layout_costs(impl):
    "By how many per cent its mean error is above that of the best layout, one digit after the point."
    given = _one_number(_pair(impl)[1], "the second part must be a number, per cent.")
    means, best, error = _means()
    limit = means[best] + error
    right = min((one for one in LAYOUTS if means[one] <= limit), key=len)
    expected = 100 * (means[right] / means[best] - 1)
    hints = {
        100 * (1 - means[best] / means[right]): "that is how far the best is below it: divide by the mean of the best",
        100 * means[right] / means[best]: "that is the whole error: how much is it above the best?",
        means[right] / means[best]: "that is a factor: per cent, above the best",
        means[right] / means[best] - 1: "that is a share: per cent",
        means[right] - means[best]: "that is a difference of relMSE: per cent of the best",
        100 * error / means[best]: "that is one standard error of the best",
        0.0: "the best is another one, and its mean is smaller",
    }
    for value, words in hints.items():
        assert not np.isclose(given, value, rtol=0, atol=0.005 * (1 + value)), f"not {given:g}: {words}."
    assert abs(given - expected) <= 0.051, f"not {given:g} per cent: divide the two means, and take 1 off."
