"""The exercises of chapter 09, a small network sets the filter's dials: what holds for a right answer."""

import numpy as np

from mcdenoise.classroom import Finding, as_numbers, as_parts, assert_matches, central_differences, graded, name_mistake


def _weights(theta, distances):
    """w_j, number by number."""
    return np.array(
        [np.exp(-sum(float(t * e) for t, e in zip(theta, one, strict=True))) for one in np.transpose(distances)]
    )


def _filtered(theta, distances, colours):
    """c_hat of one pixel."""
    weights = _weights(theta, distances)
    return sum(w * colour for w, colour in zip(weights, colours, strict=True)) / sum(weights)


def _error(filtered, reference, spp, epsilon):
    """E of one pixel."""
    return sum(float(spp / 2 * (a - b) ** 2 / (b**2 + epsilon)) for a, b in zip(filtered, reference, strict=True))


def _made_up(rng, m, n):
    """theta, distances and colours of a pixel with n neighbours; the first of them is the pixel itself."""
    distances = rng.gamma(1.0, 1.0, (m, n))
    distances[:, 0] = 0
    return rng.gamma(1.0, 0.5, m), distances, rng.gamma(1.0, 0.5, (n, 3))


def _pixel():
    """Three distances to four neighbours; new arrays each time, since an answer may spoil what it gets."""
    theta = np.array([0.5, 0.2, 2.0])
    distances = np.array([[0.0, 1.0, 2.0, 1.0], [0.0, 3.0, 0.5, 4.0], [0.0, 0.1, 0.3, 0.05]])
    return theta, distances, np.array([[0.5, 0.4, 0.1], [0.7, 0.1, 0.2], [0.2, 0.9, 0.4], [1.0, 0.3, 0.0]])


# --- filter_pixel(theta, distances, colours)

FILTERED = ("filtered (3,)", "weights (n,)")


@graded("filter_pixel", points=0.5)
def test_weights_of_one_pixel(impl):
    "w_j = exp(-sum over m of theta_m E_mj), not normalised: the pixel itself has the weight 1."
    theta, distances, colours = _pixel()
    found = as_parts(impl(theta, distances, colours), FILTERED)[1]
    expected, each = _weights(theta, distances), theta[:, np.newaxis] * distances
    mistakes = {
        "the sign of the exponent is wrong: what is far counts less": 1 / expected,
        "normalised: that comes later, the weights themselves are asked for, w = 1 at distance 0": expected
        / expected.sum(),
        "a 2 is too much in the exponent: theta is 1 / (2 sigma^2) already": np.sqrt(expected),
        "theta is taken for sigma: theta = 1 / (2 sigma^2) is multiplied, nothing is divided": np.exp(
            -(distances / (2 * theta[:, np.newaxis] ** 2)).sum(axis=0)
        ),
        "the distances are divided by theta: theta is an inverse bandwidth, multiply": np.exp(
            -(distances / theta[:, np.newaxis]).sum(axis=0)
        ),
        "theta is squared": np.exp(-(theta**2 @ distances)),
        "the distances are squared: they are sums of squares already": np.exp(-(theta @ distances**2)),
        "theta is missing": np.exp(-distances.sum(axis=0)),
        "a bell for each m, added: the sum stands in the exponent, and bells are multiplied": np.exp(-each).sum(axis=0),
        "a bell for each m, averaged: the sum stands in the exponent": np.exp(-each).mean(axis=0),
        "a row for each m: sum over m in the exponent, one weight for each neighbour": np.exp(-each),
        "the mean over m in the exponent: it is the sum": np.exp(-each.mean(axis=0)),
        "exp is missing": -each.sum(axis=0),
        "that is c_hat: the order is filtered, weights": _filtered(theta, distances, colours),
    }
    name_mistake(found, expected, mistakes, "the weights of four neighbours")
    assert_matches(found, expected, "the weights of four neighbours")


@graded("filter_pixel", points=0.5)
def test_filtered_colour_of_one_pixel(impl):
    "c_hat = sum over j of w_j c_j / S, with S = sum over j of w_j; each channel with the same weights."
    theta, distances, colours = _pixel()
    found = as_parts(impl(theta, distances, colours), FILTERED)[0]
    weights = _weights(theta, distances)
    total, expected = (weights[:, np.newaxis] * colours).sum(axis=0), _filtered(theta, distances, colours)
    mistakes = {
        "not divided by S, the sum of the weights": total,
        "divided by the number of neighbours: divide by S, the sum of the weights": total / len(weights),
        "divided by S twice": expected / weights.sum(),
        "the mean without weights": colours.mean(axis=0),
        "the pixel itself is left out: it is one of the neighbours, at distance 0": (total - colours[0])
        / (weights.sum() - 1),
        "the mean over the channels: each has a value of its own": np.full(3, expected.mean()),
        "the weighted colours are not summed": weights[:, np.newaxis] * colours / weights.sum(),
        "that is the weights: the order is filtered, weights": weights,
    }
    name_mistake(found, expected, mistakes, "c_hat")
    assert_matches(found, expected, "c_hat")


@graded("filter_pixel", points=0.5, hidden=True)
def test_pixels_of_all_sizes(impl):
    "Any number of distances and neighbours; theta 0 gives the plain mean, a large theta the pixel's own colour."
    rng = np.random.default_rng(3)
    for m, n in ((1, 1), (1, 5), (6, 2), (7, 49)):
        theta, distances, colours = _made_up(rng, m, n)
        filtered, weights = as_parts(impl(theta, distances, colours), FILTERED)
        assert_matches(weights, _weights(theta, distances), f"weights of {n} neighbours, {m} distances")
        assert_matches(filtered, _filtered(theta, distances, colours), f"c_hat of {n} neighbours, {m} distances")
        assert_matches(impl(0 * theta, distances, colours)[0], np.sum(colours, axis=0) / n, "c_hat, theta = 0")
        if m > 1:
            assert_matches(impl(1e6 + theta, distances, colours)[0], colours[0], "c_hat, theta about 1e6")


# --- filtered_error_gradient(filtered, reference, spp, epsilon)


@graded("filtered_error_gradient", points=0.5)
def test_gradient_of_the_error_of_one_pixel(impl):
    "dE/dc_hat_q = n (c_hat_q - c_q) / (c_q^2 + epsilon): chapter 08, for one pixel."
    filtered, reference, spp, epsilon = np.array([0.5, 0.1, 2.0]), np.array([0.4, 0.2, 2.5]), 9, 0.05
    difference, below = filtered - reference, reference**2 + epsilon
    expected = spp * difference / below
    mistakes = {
        "n / 2 in front: the 2 of the derivative cancels it": expected / 2,
        "2 n in front: the 1/2 in front of the sum cancels the 2": 2 * expected,
        "n, the spp, is missing": expected / spp,
        "n and 1/2 are missing": 2 * expected / spp,
        "the sign is flipped: c_hat - c, too bright is positive": -expected,
        "that is E itself, not its derivative": spp / 2 * difference**2 / below,
        "the square goes when it is differentiated": spp * difference**2 / below,
        "the sign of the difference is lost": np.abs(expected),
        "c_hat^2 + epsilon below the line: it is the reference that stands there": spp
        * difference
        / (filtered**2 + epsilon),
        "c_hat is missing: the difference of c_hat and c stands above the line": spp * -reference / below,
        "epsilon is missing": spp * difference / reference**2,
        "epsilon is another constant than the argument": spp * difference / (reference**2 + 0.01),
        "c + epsilon below the line: c is squared": spp * difference / (reference + epsilon),
        "what stands below the line is squared: it does not depend on c_hat": spp * difference / below**2,
        "nothing stands below the line: the error is relative": spp * difference,
        "the mean over the channels": expected / 3,
        "the sum over the channels: each channel of c_hat has a derivative of its own": expected.sum(),
    }
    found = impl(filtered, reference, spp, epsilon)
    name_mistake(found, expected, mistakes, "dE/dc_hat")
    assert_matches(found, expected, "dE/dc_hat")


@graded("filtered_error_gradient", points=0.5, hidden=True)
def test_the_error_agrees_with_finite_differences(impl):
    "As E itself has it, for any spp and epsilon, black references too; 0 where the filter is right."
    rng = np.random.default_rng(5)
    for spp in (1, 4, 64):
        filtered, reference, epsilon = rng.gamma(1.0, 0.5, 3), rng.gamma(1.0, 0.5, 3), float(rng.uniform(0.001, 0.1))
        reference[0] = 0

        def error(one, reference=reference, spp=spp, epsilon=epsilon):
            return _error(one, reference, spp, epsilon)

        found = impl(filtered, reference, spp, epsilon)
        assert_matches(found, central_differences(error, filtered), f"dE/dc_hat at {spp} spp", rtol=1e-6, atol=1e-6)
        assert_matches(impl(reference, reference, spp, epsilon), np.zeros(3), "dE/dc_hat where c_hat = c")


# --- filtered_by_theta(theta, distances, colours)


def _pull(weights, distances, values):
    """Sum over j of w_j E_mj v_jq, number by number: (m, 3)."""
    return np.array(
        [
            [sum(w * e * v for w, e, v in zip(weights, one, channel, strict=True)) for channel in values.T]
            for one in distances
        ]
    )


def _matrix(found, what):
    """The answer as an array of two axes, or a Finding."""
    values = as_numbers(found)
    if values is None or values.ndim != 2:
        assert_matches(found, np.zeros((3, 3)), what)
    return values


@graded("filtered_by_theta", points=1)
def test_how_a_filtered_pixel_changes_with_its_bandwidths(impl):
    "dc_hat_q/dtheta_m: a row for each theta, a column for each channel; minus a weighted covariance."
    theta, distances, colours = _pixel()
    found = impl(theta, distances, colours)
    weights, filtered = _weights(theta, distances), _filtered(theta, distances, colours)
    away, whole = colours - filtered, weights.sum()
    expected = -_pull(weights, distances, away) / whole
    mistakes = {
        "the sign is flipped: a larger theta takes weight away from what is far": -expected,
        "1 / S is missing, S the sum of the weights": expected * whole,
        "divided by S twice": expected / whole,
        "divided by the number of neighbours: it is S, the sum of the weights": expected * whole / 4,
        "c_hat is missing: S changes with theta too (quotient rule), and c_j - c_hat stands for both": -_pull(
            weights, distances, colours
        )
        / whole,
        "c_hat and 1 / S are missing: that is the derivative of sum w c alone": -_pull(weights, distances, colours),
        "the pixel's own colour is taken off: it is the filtered one, c_hat": -_pull(
            weights, distances, colours - colours[0]
        )
        / whole,
        "the plain mean of the colours is taken off: it is c_hat, their weighted mean": -_pull(
            weights, distances, colours - colours.mean(axis=0)
        )
        / whole,
        "the weights w_j are missing inside the sum": -_pull(np.ones(4), distances, away) / whole,
        "the distances E_mj are missing, and sum w (c - c_hat) is 0": np.zeros((3, 3)),
        "transposed: a row for each theta, a column for each channel": expected.T,
        "multiplied by theta: that is the derivative with respect to log theta": expected * theta[:, np.newaxis],
        "that is the derivative with respect to sigma: theta = 1 / (2 sigma^2) is asked for": -expected
        * (2 * theta[:, np.newaxis]) ** 1.5,
        "half of it: there is no 1/2 here": expected / 2,
        "twice too much: there is no square here": 2 * expected,
        "the sum over the channels: each has a derivative of its own": expected.sum(axis=1),
        "the sum over theta: each has a row of its own": expected.sum(axis=0),
        "the sum over the neighbours is missing": -np.array(
            [np.outer(w * e, a) for w, e, a in zip(weights, distances.T, away, strict=True)]
        )
        / whole,
    }
    name_mistake(found, expected, mistakes, "dc_hat/dtheta")
    assert_matches(found, expected, "dc_hat/dtheta")


@graded("filtered_by_theta", points=0.5)
def test_when_a_bandwidth_changes_nothing(impl):
    "0 where all neighbours are at one distance, or all have one colour; the same if all colours grow by one amount."
    theta, distances, colours = _pixel()
    distances[1], what = 3.0, "dc_hat/dtheta where E_m is 3 for all neighbours"
    assert_matches(_matrix(impl(theta, distances, colours), what)[1], np.zeros(3), what, atol=1e-9)
    theta, distances, colours = _pixel()
    flat = np.tile([0.3, 0.2, 0.9], (4, 1))
    what = "dc_hat/dtheta where all neighbours have one colour"
    assert_matches(impl(theta, distances, flat), np.zeros((3, 3)), what, atol=1e-9)
    before, after = impl(theta, distances, colours), impl(theta, distances, colours + 0.5)
    assert_matches(after, np.asarray(before), "dc_hat/dtheta of colours that are all 0.5 brighter", atol=1e-9)


@graded("filtered_by_theta", points=1, hidden=True)
def test_the_filter_agrees_with_finite_differences(impl):
    "As the filter has it, for any number of theta and neighbours; 0 for a pixel that is alone."
    rng = np.random.default_rng(7)
    for m, n in ((1, 1), (1, 4), (6, 2), (5, 25)):
        theta, distances, colours = _made_up(rng, m, n)
        expected = np.transpose(
            [
                central_differences(lambda one, q=q, e=distances, c=colours: float(_filtered(one, e, c)[q]), theta)
                for q in range(3)
            ]
        )
        assert_matches(impl(theta, distances, colours), expected, f"dc_hat/dtheta, {m} of {n}", rtol=1e-6, atol=1e-8)


# --- which_way


@graded("which_way", points=1)
def test_which_way_each_dial_should_go(impl):
    "The sign of dE/dtheta for each of the five pixels."
    given = ("0", "0", "0", "0", "0")
    signs = [str(one).strip().replace("−", "-") for one in impl] if isinstance(impl, (tuple, list, str)) else []
    assert len(signs) == 5, f"5 signs are needed, as in {given}."
    hints = (
        ("A", "+", "the middle is too bright by chance. Does a larger theta bring c_hat nearer to its neighbours, or to itself?"),
        ("B", "-", "the other paint is mixed in. A larger theta of albedo keeps it out: does the error rise or fall?"),
        ("C", "0", "what is E of albedo between two pixels of one paint, and what is theta times that?"),
        ("D", "-", "the lit side is mixed in. What happens to it if only near pixels count?"),
        ("E", "+", "the albedo is noise. Whom does it choose if theta is larger: those that are right, or those that err alike?"),
    )  # fmt: skip
    for sign, (name, right, hint) in zip(signs, hints, strict=True):
        assert sign in ("+", "-", "0"), f'{name}: {sign!r} is none of "+", "-" and "0".'
        assert sign == right, f"{name} is not {sign}: {hint}"


# --- softplus_link(d_theta, theta)


@graded("softplus_link", points=0.5)
def test_through_softplus_with_theta_alone(impl):
    "dE/dz = dE/dtheta times the slope of softplus, which theta itself knows; each number for itself."
    z = np.log([[1.0, 3.0], [1 / 4, 9.0]])
    theta, d_theta = np.log([[2.0, 4.0], [5 / 4, 10.0]]), np.array([[4.0, -2.0], [1.0, 5.0]])
    slope = np.array([[1 / 2, 3 / 4], [1 / 5, 9 / 10]])
    expected = d_theta * slope
    mistakes = {
        "d_theta is missing: the chain rule multiplies by what arrives": slope,
        "d_theta is added: the chain rule multiplies": d_theta + slope,
        "that is e^-theta: 1 minus it is the slope": d_theta * (1 - slope),
        "the sigmoid of theta: the slope is the sigmoid of z, and theta is not z": d_theta / (1 + np.exp(-theta)),
        "s (1 - s) is the slope of the sigmoid; theta comes out of softplus": d_theta * slope * (1 - slope),
        "the slope is taken as theta (1 - theta): that is the sigmoid's rule, theta comes out of softplus": d_theta
        * theta
        * (1 - theta),
        "a sign in the exponent is wrong: e^-theta, not e^theta": d_theta * (1 - np.exp(theta)),
        "1 + e^-theta: a sign is wrong": d_theta * (2 - slope),
        "divided by the slope: multiply": d_theta / slope,
        "the sign is flipped: softplus rises": -expected,
        "multiplied by theta: its slope is asked for": d_theta * theta,
        "softplus is applied once more: theta is already its output": d_theta * np.log(1 + np.exp(theta)),
        "that is dE/dtheta, unchanged": d_theta,
        "that is z: it is dE/dz that is asked for": z,
        "the sum over the pixels: each number for itself": expected.sum(axis=0),
        "the mean over the pixels: each number for itself": expected / 2,
    }
    found = impl(d_theta, theta)
    name_mistake(found, expected, mistakes, "dE/dz")
    assert_matches(found, expected, "dE/dz")


@graded("softplus_link", points=0.5)
def test_softplus_link_at_both_ends(impl):
    "theta = 0: 0; theta large: d_theta itself, without a warning."
    theta, d_theta = np.array([0.0, 1000.0, 1e8]), np.array([3.0, 2.0, -4.0])
    found, what = impl(d_theta, theta), "dE/dz at theta = 0, 1000 and 1e8"
    values = as_numbers(found)
    if values is not None and values.shape == theta.shape:
        for one, value in zip(theta, values, strict=True):
            assert not np.isnan(value), (
                f"{what}: NaN at theta = {one:g}. z = log(e^theta - 1) overflows there, but z is not needed: write the slope "
                f"with e^-theta."
            )
    assert_matches(found, np.array([0.0, 2.0, -4.0]), what)
    assert not impl.warned, (
        f"{what}: right, but NumPy warns on the way. Take e^-theta, which never overflows; z is not needed."
    )


@graded("softplus_link", points=0.5, hidden=True)
def test_the_link_agrees_with_finite_differences(impl):
    "As softplus has it, for any shape."
    rng = np.random.default_rng(9)
    for shape in ((1,), (5, 3), (4, 6, 2)):
        z, d_theta = 2 * rng.normal(size=shape), rng.normal(size=shape)
        expected = central_differences(lambda one, d=d_theta: float(np.sum(d * np.log1p(np.exp(one)))), z)
        assert_matches(impl(d_theta, np.log1p(np.exp(z))), expected, f"dE/dz of shape {shape}", atol=1e-8)


# --- chain_rule(weight, bias, x, distances, colours, reference, spp, epsilon)

CHAIN = ("error", "d_weight", "d_bias")


def _batch(rng, n, d, m, k, spp=4, epsilon=0.01):
    """The arguments of `chain_rule` for n pixels."""
    pixels = [_made_up(rng, m, k) for _ in range(n)]
    return {
        "weight": rng.normal(size=(m, d)),
        "bias": rng.normal(size=m),
        "x": rng.normal(size=(n, d)),
        "distances": np.array([one[1] for one in pixels]),
        "colours": np.array([one[2] for one in pixels]),
        "reference": rng.gamma(2.0, 0.3, (n, 3)),
        "spp": spp,
        "epsilon": epsilon,
    }


def _loss(weight, bias, x, distances, colours, reference, spp, epsilon):
    """E, pixel by pixel."""
    theta = np.log1p(np.exp(x @ weight.T + bias))
    each = [
        _error(_filtered(t, e, c), right, spp, epsilon)
        for t, e, c, right in zip(theta, distances, colours, reference, strict=True)
    ]
    return sum(each) / len(each)


def _gradients(given):
    """dE/dweight and dE/dbias by differences."""
    return tuple(
        central_differences(lambda one, name=name: _loss(**(given | {name: one})), given[name], 2e-5)
        for name in ("weight", "bias")
    )


def _one_by_one(given):
    """The same arguments for each pixel alone."""
    per_pixel = ("x", "distances", "colours", "reference")
    return [given | {name: given[name][i : i + 1] for name in per_pixel} for i in range(len(given["x"]))]


@graded("chain_rule", points=0.5)
def test_error_of_some_pixels(impl):
    "E = mean over the pixels of n/2 sum_q (c_hat_q - c_q)^2 / (c_q^2 + epsilon), theta = softplus(x W^T + b)."
    given = _batch(np.random.default_rng(11), n=5, d=2, m=3, k=6, spp=8, epsilon=0.02)
    expected, what = _loss(**given), "E of five pixels"
    each = [_loss(**one) for one in _one_by_one(given)]
    mistakes = {
        "the sum over the pixels: their mean is asked for": 5 * expected,
        "1/2 is missing": 2 * expected,
        "n, the spp, is missing": expected / 8,
        "n/2 is missing": expected / 4,
        "E of the last pixel alone: add them up": each[-1],
        "the last pixel alone, divided by their number: add them up": each[-1] / 5,
        "the first pixel alone: is there a `return` inside the loop?": each[0],
        "the mean over the channels: they are summed": expected / 3,
        "epsilon is another constant than the argument": _loss(**(given | {"epsilon": 0.01})),
        "softplus is missing between network and filter": _without_softplus(given),
        "the bias is missing": _loss(**(given | {"bias": np.zeros(3)})),
    }
    found = as_parts(impl(*given.values()), CHAIN)[0]
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)


def _without_softplus(given):
    """E if the network's sums went into the filter as they are."""
    z = given["x"] @ given["weight"].T + given["bias"]
    parts = zip(z, given["distances"], given["colours"], given["reference"], strict=True)
    return float(np.mean([_error(_filtered(t, e, c), right, 8, 0.02) for t, e, c, right in parts]))


@graded("chain_rule", points=1)
def test_gradients_of_the_network_through_the_filter(impl):
    "dE/dweight and dE/dbias: all pixels use the same network, so what arrives from each of them is added, then averaged."
    given = _batch(np.random.default_rng(12), n=4, d=3, m=3, k=5, spp=8)
    expected = _gradients(given)
    each = [_gradients(one) for one in _one_by_one(given)]
    theta = np.log1p(np.exp(given["x"] @ given["weight"].T + given["bias"]))
    slope = 1 - np.exp(-theta)
    d_z = np.array([one[1] for one in each])  # dE_i/db = dE_i/dz
    found = as_parts(impl(*given.values()), CHAIN)
    for place, name in ((2, "d_bias"), (1, "d_weight")):
        right = expected[place - 1]
        parts = np.array([one[place - 1] for one in each])

        def through(d, name=name):
            """Mean over the pixels of what d, in place of dE/dz, would give."""
            return d.mean(axis=0) if name == "d_bias" else d.T @ given["x"] / len(d)

        mistakes = {
            "the sum over the pixels: E is their mean, and so is its gradient": 4 * right,
            "the last pixel alone: add up what arrives from each": parts[-1],
            "the last pixel alone, divided by their number: add up what arrives from each": parts[-1] / 4,
            "the sum over the pixels is missing": parts,
            "the sign is flipped: the step against it comes later": -right,
            "the link is missing: dE/dtheta must go through softplus to dE/dz": through(d_z / slope),
            "the link is there twice": through(d_z * slope),
            "the sigmoid of theta in the link: it is that of z, 1 - e^-theta": through(
                d_z / slope / (1 + np.exp(-theta))
            ),
            "n, the spp, is missing": right / 8,
            "transposed: a gradient has the shape of its parameter, a row for each theta": right.T,
        }
        if name == "d_weight":
            mistakes["x is missing: dz_m / dw_mt = x_t"] = np.tile(d_z.mean(axis=0)[:, np.newaxis], (1, 3))
            mistakes["the means of dE/dz and of x, multiplied: multiply pixel by pixel, then take the mean"] = np.outer(
                d_z.mean(axis=0), given["x"].mean(axis=0)
            )
            mistakes["the sums of dE/dz and of x, multiplied: multiply pixel by pixel, then take the mean"] = np.outer(
                d_z.sum(axis=0), given["x"].sum(axis=0)
            )
        else:
            mistakes["multiplied by x: the bias has an input that is always 1"] = (d_z * given["x"]).mean(axis=0)
        name_mistake(found[place], right, mistakes, name)
        assert_matches(found[place], right, name, rtol=1e-5, atol=1e-7)


@graded("chain_rule", points=0.5, hidden=True)
def test_the_chain_agrees_with_finite_differences(impl):
    "Any number of pixels, inputs, bandwidths and neighbours, one of each too; a filter that is right has no gradient."
    rng = np.random.default_rng(13)
    for n, d, m, k in ((1, 1, 1, 2), (2, 4, 1, 3), (3, 1, 5, 4)):
        given = _batch(rng, n, d, m, k, spp=16, epsilon=0.03)
        found = as_parts(impl(*given.values()), CHAIN)
        assert_matches(found[0], _loss(**given), f"E of {n} pixels")
        for one, right, name in zip(found[1:], _gradients(given), CHAIN[1:], strict=True):
            assert_matches(one, right, f"{name} of {n} pixels, {d} inputs, {m} theta", rtol=1e-5, atol=1e-7)
    given["colours"][:] = given["reference"][:, np.newaxis]
    assert_matches(as_parts(impl(*given.values()), CHAIN)[1], np.zeros((5, 1)), "d_weight where c_hat = c", atol=1e-9)


# --- one_epoch(parameters, state, data)

EPOCH = ("parameters", "state", "error")
NAMES = ("weight", "bias")


def _start(seed, step=0.1):
    """parameters, state and data of a network before its first epoch."""
    data = _batch(np.random.default_rng(seed), n=3, d=2, m=2, k=4)
    parameters = {name: data.pop(name) for name in NAMES}
    return parameters, {name: (np.zeros(one.shape), np.full(one.shape, step)) for name, one in parameters.items()}, data


def _epoch(impl, parameters, state, data):
    """What an epoch gives back, looked at from outside."""
    found = as_parts(impl(parameters, state, data), EPOCH)
    for part, name in zip(found[:2], EPOCH, strict=False):
        if not isinstance(part, dict) or set(part) != set(NAMES):
            raise Finding(
                f"{name} must be a dict with the names weight and bias, as it came; something else came back."
            )
    for name, pair in found[1].items():
        if not isinstance(pair, (tuple, list)) or len(pair) != 2:
            raise Finding(f"state[{name!r}] must be a pair (sign, step); something else came back.")
    return found


def _compare(found, expected, mistakes, what):
    """Look a result up among the mistakes, then compare."""
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what, rtol=1e-5, atol=1e-8)


@graded("one_epoch", points=0.5)
def test_the_first_epoch(impl):
    "No sign is remembered: every parameter goes one step of the given length against its gradient; E is that before."
    parameters, state, data = _start(21)
    new, after, error = _epoch(impl, parameters, state, data)
    gradients = _gradients(parameters | data)
    moved = {}
    for name, gradient in zip(NAMES, gradients, strict=True):
        sign = np.sign(gradient)
        before, moved[name] = parameters[name], parameters[name] - 0.1 * sign
        mistakes = {
            "it climbs: a step against the sign of the gradient": before + 0.1 * sign,
            "it does not move": before,
            "the gradient times the step: only its sign counts": before - 0.1 * gradient,
            "the step has grown: a sign of 0 was remembered, so it stays": before - 0.12 * sign,
            "the step has shrunk: a sign of 0 was remembered, so it stays": before - 0.05 * sign,
            "all go the same way: the sign of the gradient is missing": before - 0.1,
        }
        _compare(new[name], moved[name], mistakes, f"{name} after one epoch")
        mistakes = {
            "nothing is remembered: put the sign of this gradient there": np.zeros(sign.shape),
            "the gradient itself is remembered: its sign is needed": gradient,
            "flipped: the sign of the gradient, not that of the move": -sign,
        }
        _compare(after[name][0], sign, mistakes, f"state of {name}: the sign")
        mistakes = {
            "it has grown: no sign was remembered, so it stays": np.full(sign.shape, 0.12),
            "it has shrunk: no sign was remembered, so it stays": np.full(sign.shape, 0.05),
            "that is the sign: the pair is (sign, step)": sign,
        }
        _compare(after[name][1], np.full(sign.shape, 0.1), mistakes, f"state of {name}: the step")
    expected = _loss(**parameters, **data)
    mistakes = {
        "that is E after the step: before it is asked for": _loss(**moved, **data),
        "the sum over the pixels: E is their mean": 3 * expected,
    }
    _compare(error, expected, mistakes, "E")


@graded("one_epoch", points=1)
def test_the_state_goes_on(impl):
    "Signs agree: the step grows by 1.2. A sign has flipped: it is halved, the parameter waits, 0 is remembered."
    parameters, _, data = _start(22)
    gradients, what = _gradients(parameters | data), "one epoch of a training that is under way"
    for name, gradient in zip(NAMES, gradients, strict=True):
        sign = np.sign(gradient)
        flips = np.indices(sign.shape).sum(axis=0) % 2 == 1  # every second one
        state = {one: (np.zeros(array.shape), np.full(array.shape, 0.4)) for one, array in parameters.items()}
        state[name] = (np.where(flips, -sign, sign), state[name][1])
        new, after, _ = _epoch(impl, parameters, state, data)
        step, before = np.where(flips, 0.2, 0.48), parameters[name]
        mistakes = {
            "it stays as it was: the state is not used": np.full(sign.shape, 0.4),
            "it does not grow where the signs agree": np.where(flips, 0.2, 0.4),
            "it does not shrink where the sign has flipped": np.where(flips, 0.4, 0.48),
            "it grows where the sign has flipped, and shrinks where it agrees": np.where(flips, 0.48, 0.2),
            "it starts anew: the state that came in must be used": np.full(sign.shape, 0.1),
        }
        _compare(after[name][1], step, mistakes, f"{what}: step of {name}")
        mistakes = {
            "the new sign is remembered where it has flipped: it must be 0, or the next epoch shrinks once more": sign,
            "that is the sign that came in: remember the new one": state[name][0],
            "nothing is remembered: put the sign of this gradient there": np.zeros(sign.shape),
        }
        _compare(after[name][0], np.where(flips, 0, sign), mistakes, f"{what}: sign of {name}")
        mistakes = {
            "it moves where the sign has flipped: there it waits for one epoch": before - sign * step,
            "the step of the epoch before is taken, not the new one": before - np.where(flips, 0, sign) * 0.4,
            "it moves where the sign has flipped, by the step of the epoch before": before - sign * 0.4,
            "it climbs": before + np.where(flips, 0, sign) * step,
            "it does not move": before,
        }
        _compare(new[name], before - np.where(flips, 0, sign) * step, mistakes, f"{what}: {name}")


@graded("one_epoch", points=0.5, hidden=True)
def test_some_epochs_in_a_row(impl):
    "Six epochs, each from the state that the one before gave back; steps stay between 1e-6 and 50."
    parameters, state, data = _start(23, step=0.3)
    right = {name: [one.copy(), *state[name]] for name, one in parameters.items()}
    for turn in range(6):
        gradients = _gradients({name: one[0] for name, one in right.items()} | data)
        expected = _loss(**{name: one[0] for name, one in right.items()}, **data)
        parameters, state, error = _epoch(impl, parameters, state, data)
        for (name, one), gradient in zip(right.items(), gradients, strict=True):
            right[name] = _walk(*one, np.sign(gradient))
            assert_matches(parameters[name], right[name][0], f"{name} after epoch {turn + 1}", rtol=1e-5, atol=1e-7)
            assert_matches(state[name][0], right[name][1], f"sign of {name} after epoch {turn + 1}")
            assert_matches(state[name][1], right[name][2], f"step of {name} after epoch {turn + 1}")
        assert_matches(error, expected, f"E in epoch {turn + 1}", rtol=1e-5)
    parameters, _, data = _start(24)
    signs = dict(zip(NAMES, map(np.sign, _gradients(parameters | data)), strict=True))
    state = {name: (sign, np.full(sign.shape, 49.0)) for name, sign in signs.items()}
    for name, (_, step) in _epoch(impl, parameters, state, data)[1].items():
        assert_matches(step, np.full(signs[name].shape, 50.0), f"the largest step of {name}")
    state = {name: (-sign, np.full(sign.shape, 1.5e-6)) for name, sign in signs.items()}
    for name, (_, step) in _epoch(impl, parameters, state, data)[1].items():
        assert_matches(step, np.full(signs[name].shape, 1e-6), f"the smallest step of {name}")


def _walk(parameter, sign, step, now):
    """One step of RPROP, number by number."""
    parameter, sign, step = parameter.copy(), sign.copy(), step.copy()
    for place in np.ndindex(parameter.shape):
        one = now[place]
        if one * sign[place] > 0:
            step[place] = min(step[place] * 1.2, 50.0)
        elif one * sign[place] < 0:
            step[place], one = max(step[place] / 2, 1e-6), 0.0
        sign[place] = one
        parameter[place] -= one * step[place]
    return [parameter, sign, step]


# --- share_of_the_way(unfiltered, filtered, oracle)


@graded("share_of_the_way", points=0.5)
def test_how_far_from_unfiltered_to_the_oracle(impl):
    "0 without a filter, 1 at the oracle, and each factor counts alike: the logarithm of relMSE is what is shared out."
    unfiltered, filtered, oracle = 0.16, 0.04, 0.01
    mistakes = {
        "without the logarithm: from 0.16 to 0.04 is a factor of 4, and so is it from 0.04 to 0.01": 0.8,
        "that is one of the factors, not a share": 4.0,
        "that is what is left of the error": 0.25,
        "that is the whole way: unfiltered to the oracle stands below the line": float(np.log(4)),
        "upside down: the way that was gone over the whole way": 2.0,
        "the sign is flipped: less error is forward": -0.5,
    }
    name_mistake(impl(unfiltered, filtered, oracle), 0.5, mistakes, "from 0.16 by 0.04 to 0.01")
    assert_matches(impl(unfiltered, filtered, oracle), 0.5, "from 0.16 by 0.04 to 0.01")
    what, found = "from 0.1 by 0.02 to 0.001", impl(0.1, 0.02, 0.001)
    expected = (np.log10(0.1) - np.log10(0.02)) / 2
    mistakes = {"that is the way that is left, 1 minus the share": 1 - expected, "in per cent": 100 * expected}
    name_mistake(found, expected, mistakes, what)
    assert_matches(found, expected, what)
    found = impl(0.02, 0.08, 0.005)
    assert as_numbers(found) is None or np.any(as_numbers(found) < 0), (
        "a filter that does harm (0.02 to 0.08) goes backwards: its share is below 0, do not clip it or take its size."
    )
    assert_matches(found, -1.0, "a filter that does harm")


@graded("share_of_the_way", points=0.5, hidden=True)
def test_shares_of_any_errors(impl):
    "Any three errors; 0 where nothing is gained, 1 at the oracle, the same if all are ten times larger."
    rng = np.random.default_rng(17)
    for _ in range(5):
        oracle, middle, unfiltered = np.sort(rng.uniform(0.001, 1.0, 3)).tolist()
        expected = (np.log2(unfiltered) - np.log2(middle)) / (np.log2(unfiltered) - np.log2(oracle))
        assert_matches(impl(unfiltered, middle, oracle), expected, "the share")
        assert_matches(impl(10 * unfiltered, 10 * middle, 10 * oracle), expected, "the share of ten times the errors")
        assert_matches(impl(unfiltered, unfiltered, oracle), 0.0, "the share where nothing is gained")
        assert_matches(impl(unfiltered, oracle, oracle), 1.0, "the share of the oracle")


# --- group_ablation(theta, distances, colours, reference)

ABLATION = ("errors (m,)", "most")


def _relmse(theta, distances, colours, reference):
    """relMSE of some pixels that share theta."""
    filtered = np.array([_filtered(theta, e, c) for e, c in zip(distances, colours, strict=True)])
    return float(np.mean((filtered - reference) ** 2 / (reference**2 + 0.01)))


def _ablation(given):
    """The errors without each theta."""
    theta, *rest = given
    return np.array([_relmse(np.where(np.arange(len(theta)) == k, 0, theta), *rest) for k in range(len(theta))])


def _paints(seed, n=12, k=9, m=3):
    """Pixels of two paints: distance 1 tells them apart, the others are chance."""
    rng = np.random.default_rng(seed)
    distances = rng.gamma(1.0, 1.0, (n, m, k))
    other = rng.random((n, k)) < 0.4
    distances[:, 1] = 30 * other
    distances[:, :, 0], other[:, 0] = 0, False
    reference = rng.uniform(0.2, 0.6, (n, 3))
    colours = np.where(other[..., np.newaxis], 3.0, 1.0) * reference[:, np.newaxis] * rng.uniform(0.7, 1.3, (n, k, 1))
    return np.array([0.4, 0.3, 0.3])[:m], distances, colours, reference


@graded("group_ablation", points=0.5)
def test_errors_without_each_group(impl):
    "errors[m]: relMSE of all pixels if theta_m alone is 0, so that nobody asks group m; epsilon is 0.01."
    given = _paints(31)
    theta = given[0]
    found, expected = as_parts(impl(*given), ABLATION)[0], _ablation(given)
    only = np.array([_relmse(np.where(np.arange(3) == k, theta, 0), *given[1:]) for k in range(3)])
    more = np.array([_relmse(np.where(np.arange(3) > k, theta, 0), *given[1:]) for k in range(3)])
    strict = np.array([_relmse(np.where(np.arange(3) == k, 1e8, theta), *given[1:]) for k in range(3)])
    whole = _relmse(*given)
    mistakes = {
        "group m alone is asked: it alone must be left out": only,
        "groups that were left out stay out: begin with the whole theta each time": more,
        "theta_m is made large: that asks group m alone. 0 leaves it out": strict,
        "nothing is left out": np.full(3, whole),
        "the difference to the error with all groups: the error itself is asked for": expected - whole,
        "the ratio to the error with all groups: the error itself is asked for": expected / whole,
        "the sum over the pixels, mean over the channels: the mean over both": 12 * expected,
        "the sum over the channels: the mean over pixels and channels": 3 * expected,
        "the sum over pixels and channels: their mean": 36 * expected,
    }
    name_mistake(found, expected, mistakes, "relMSE without each of three groups")
    assert_matches(found, expected, "relMSE without each of three groups")


@graded("group_ablation", points=0.5)
def test_the_group_that_matters_most(impl):
    "most: the index of the group without which the error is largest."
    given = _paints(32)
    most, errors = as_parts(impl(*given), ABLATION)[1], _ablation(given)
    if most is None or isinstance(most, str) or np.shape(most) != ():
        assert_matches(most, 1, "most")
    hints = {
        int(np.argmin(errors)): "that is the group without which the error is smallest: nobody misses it",
        int(np.argmax(given[0])): "a large theta is no proof: the one that is missed most is asked for",
    }
    assert not np.isclose(errors, most).any(), "that is the error itself: the index of its group is asked for."
    assert most == 1, f"most is {most}, expected 1: {hints.get(most, 'the index of the largest error')}."


@graded("group_ablation", points=0.5, hidden=True)
def test_ablation_of_any_pixels(impl):
    "Any number of pixels, groups and neighbours; one group too, without which all neighbours count alike."
    rng = np.random.default_rng(33)
    for n, k, m in ((1, 2, 1), (4, 7, 5), (20, 3, 2)):
        pixels = [_made_up(rng, m, k) for _ in range(n)]
        given = (
            pixels[0][0],
            np.array([p[1] for p in pixels]),
            np.array([p[2] for p in pixels]),
            rng.gamma(2, 0.3, (n, 3)),
        )
        errors, most = as_parts(impl(*given), ABLATION)
        expected = _ablation(given)
        assert_matches(errors, expected, f"relMSE without each of {m} groups")
        assert most == int(np.argmax(expected)), f"most of {m} groups is {int(np.argmax(expected))}, yours is {most}."


# --- blind_spot(noise)

SIGMAS = (0.0, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.3, 1.7, 2.2, 3.0, 4.0, 6.0, 10.0, 30.0, 1e4)  # pixels
APART = 4.0


def _blurred(image, sigma):
    """The image under a Gaussian, normalised at borders; sigma 0 leaves it."""
    if sigma == 0:
        return image
    for axis in (0, 1):
        place = np.arange(image.shape[axis])
        bell = np.exp(-((place[:, np.newaxis] - place) ** 2) / (2 * sigma**2))
        image = np.moveaxis(np.tensordot(bell / bell.sum(axis=1, keepdims=True), image, (1, axis)), 0, axis)
    return image


def _assert_blind(impl, noise, what):
    """No sigma is within 4 times the best error for both lights."""
    names = ("first light (h, w)", "second light (h, w)")
    lights = []
    for light, name in zip(as_parts(impl(noise), names), names, strict=True):
        values = as_numbers(light)
        if values is None or values.shape != noise.shape:
            assert_matches(light, np.zeros(noise.shape), f"{what}: the {name}")
        assert np.isfinite(values).all(), f"{what}: the {name} must be finite."
        assert values.min() >= 0, f"{what}: the {name} has negative values, light has none."
        lights.append(values)
    errors = np.array([[np.mean((_blurred(one + noise, s) - one) ** 2) for s in SIGMAS] for one in lights])
    ratio = errors / errors.min(axis=1, keepdims=True)
    place = int(np.argmin(ratio.max(axis=0)))
    best = [f"{SIGMAS[k]:g}" for k in errors.argmin(axis=1)]
    same = "Are they the same?" if np.array_equal(*lights) else "Are both flat, or do both have details?"
    assert ratio.max(axis=0)[place] >= APART, (
        f"{what}: with sigma = {SIGMAS[place]:g} pixels both errors are within {ratio.max(axis=0)[place]:.3g} times their "
        f"best (which the lights have at sigma = {' and '.join(best)}); more than {APART:g} is needed. {same} "
        f"One light should want a wide filter, the other one a narrow one, and each should pay for the other's."
    )


@graded("blind_spot", points=1)
def test_one_dial_cannot_serve_both(impl):
    "Whatever sigma the network says, one of the two images has more than 4 times the error that it could have."
    rng = np.random.default_rng(41)
    _assert_blind(impl, 0.1 * rng.normal(size=(24, 24)), "noise of 0.1, 24 x 24 pixels")


@graded("blind_spot", points=0.5, hidden=True)
def test_blind_spots_of_any_noise(impl):
    "Noise of any strength and size, also in images that are not square."
    rng = np.random.default_rng(42)
    for strength, size in ((0.01, (20, 30)), (1.0, (32, 24))):
        _assert_blind(impl, strength * rng.normal(size=size), f"noise of {strength:g}, {size[0]} x {size[1]} pixels")
