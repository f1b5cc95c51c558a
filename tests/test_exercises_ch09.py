"""The exercises of chapter 09 tested themselves: the reference earns every point, each typical mistake is named."""

import numpy as np
import pytest

from answers import EXERCISES, ROOT, assert_earns_every_point, assert_mistake_is_named, reference
from mcdenoise.classroom.checking.pytest_plugin import load_answer
from mcdenoise.lbf import FilterLayer, Primary, secondary_features
from mcdenoise.lbf.pixel import filter_pixel, filtered_by_theta, filtered_error_gradient
from mcdenoise.nn import MLP, RPROP, Linear, Softplus

pytestmark = pytest.mark.ch09
NOTEBOOK = ROOT / "notebooks" / "ch09_lbf.py"


# --- one pixel


def weigh(theta, distances):
    return np.exp(-np.einsum("m,mn->n", theta, distances))


def pixel(weights=weigh, filtered=lambda w, c: w @ c / w.sum()):
    """The filter at one pixel, from (theta, distances) and (weights, colours)."""

    def function(theta, distances, colours):
        found = weights(theta, distances)
        return filtered(found, colours), found

    return function


def bell_each(combine):
    """A bell for each distance, put together in some way; c_hat of the right weights."""
    return lambda t, e, c: (pixel()(t, e, c)[0], combine(np.exp(-t[:, np.newaxis] * e)))


def spoiling_pixel(theta, distances, colours):
    distances *= theta[:, np.newaxis]
    return pixel()(np.ones_like(theta), distances, colours)


def error_slope(formula):
    """An answer from (difference, reference, filtered, spp, epsilon)."""
    return lambda filtered, reference, spp, epsilon: formula(filtered - reference, reference, filtered, spp, epsilon)


right_error = error_slope(lambda d, c, f, n, e: n * d / (c**2 + e))


def by_theta(formula):
    """An answer from (weights, sum of them, distances, colours, filtered, theta)."""

    def function(theta, distances, colours):
        w = weigh(theta, distances)
        return formula(w, w.sum(), distances, colours, w @ colours / w.sum(), theta)

    return function


right_slopes = by_theta(lambda w, s, e, c, f, t: -np.einsum("n,mn,nq->mq", w, e, c - f) / s)
centred = by_theta(  # another right idea: minus a covariance of distance and colour
    lambda w, s, e, c, f, t: -np.einsum("n,mn,nq->mq", w, e - (e @ w / s)[:, np.newaxis], c) / s
)
quotient = by_theta(  # and another: the quotient rule as it stands
    lambda w, s, e, c, f, t: (-(w * e) @ c * s + np.outer((w * e).sum(axis=1), w @ c)) / s**2
)


def by_z(d_theta, theta):
    """By way of z, which overflows."""
    z = np.log(np.exp(theta) - 1)
    return d_theta / (1 + np.exp(-z))


def by_ratio(d_theta, theta):
    return d_theta * (np.exp(theta) - 1) / np.exp(theta)


def quiet_by_z(d_theta, theta):
    with np.errstate(all="ignore"):
        return by_z(d_theta, theta)


# --- the chain


def chain(link=None, arrives=None, finish=None, average=True, *, error=None, start=None):
    """The whole chain, each part open to a mistake; `finish` is a function of (d_z, x) to both gradients."""

    def function(weight, bias, x, distances, colours, reference, spp, epsilon):
        z = x @ weight.T + bias if start is None else start(weight, bias, x)
        theta = np.logaddexp(0, z)
        each, d_z = [], np.zeros(theta.shape)
        for i in range(len(x)):
            filtered, _ = pixel()(theta[i], distances[i], colours[i])
            each.append(spp / 2 * np.sum((filtered - reference[i]) ** 2 / (reference[i] ** 2 + epsilon)))
            d_theta = right_slopes(theta[i], distances[i], colours[i]) @ right_error(
                filtered, reference[i], spp, epsilon
            )
            if arrives:
                d_theta = arrives(d_theta, spp)
            d_z[i] = link(d_theta, theta[i]) if link else d_theta * (1 - np.exp(-theta[i]))
        d_weight, d_bias = finish(d_z, x) if finish else (d_z.T @ x, d_z.sum(axis=0))
        below = len(x) if average else 1
        return (error(each, len(x), spp) if error else np.mean(each)), d_weight / below, d_bias / below

    return function


right_chain = chain()


def chain_of_sums(weight, bias, x, distances, colours, reference, spp, epsilon):
    """What the network puts out goes into the filter without softplus."""
    z = x @ weight.T + bias
    filtered = [pixel()(*one)[0] for one in zip(z, distances, colours, strict=True)]
    errors = spp / 2 * (np.array(filtered) - reference) ** 2 / (reference**2 + epsilon)
    return errors.sum(axis=1).mean(), 0 * weight, 0 * bias


def fixed_epsilon(*given):
    return right_chain(*given[:-1], 0.01)


def early_return(weight, bias, x, distances, colours, reference, spp, epsilon):
    return right_chain(weight, bias, x[:1], distances[:1], colours[:1], reference[:1], spp, epsilon)


def epoch(moved=None, remembered=None, stepped=None, *, after=None, spoil=False):
    """One epoch, each part open to a mistake; `after` changes all that comes back."""

    def function(parameters, state, data):
        error, *gradients = right_chain(**parameters, **data)
        new, kept = {}, {}
        for (name, before), gradient in zip(parameters.items(), gradients, strict=True):
            sign, step = state[name]
            now = np.sign(gradient)
            agree = now * sign
            factor = stepped(agree) if stepped else np.where(agree > 0, 1.2, np.where(agree < 0, 0.5, 1.0))
            longer, used = np.clip(step * factor, 1e-6, 50.0), np.where(agree < 0, 0.0, now)
            new[name] = moved(before, used, now, longer, step, gradient) if moved else before - used * longer
            kept[name] = (remembered(now, used, sign, gradient) if remembered else used, longer)
            if spoil:
                before -= used * longer
        return after(new, kept, error, parameters, state, data) if after else (new, kept, error)

    return function


right_epoch = epoch()


def only_weight(new, kept, error, parameters, state, data):
    return new | {"bias": parameters["bias"]}, kept, error


# --- shares, groups, lights


def ablation(leave=None, error=None, pick=np.argmax, change=None):
    """Errors without each group, and the group that is picked; `leave` makes theta without group k."""

    def function(theta, distances, colours, reference):
        def of(one):
            filtered = np.array([pixel()(one, e, c)[0] for e, c in zip(distances, colours, strict=True)])
            return error(filtered, reference) if error else np.mean((filtered - reference) ** 2 / (reference**2 + 0.01))

        index = np.arange(len(theta))
        found = np.array([of(leave(theta, index, k) if leave else np.where(index == k, 0, theta)) for k in index])
        return (change(found, of(theta)) if change else found), int(pick(found))

    return function


right_ablation = ablation()


def spoiling_ablation(theta, distances, colours, reference):
    errors = []
    for k in range(len(theta)):
        theta[k] = 0
        errors.append(right_ablation(theta, distances, colours, reference)[0][k])
    return np.array(errors), int(np.argmax(errors))


def with_pick(pick):
    return lambda *given: (right_ablation(*given)[0], pick(right_ablation(*given)[0], given))


def board(shape, low=0.0, high=10.0):
    return np.where(np.indices(shape).sum(axis=0) % 2, low, high)


def stripes(noise):
    """Another right idea: half the image is lit, and a flat light; the noise is smaller than the step."""
    light = np.where(np.arange(noise.shape[1]) % 4 < 2, 0.0, 100.0) + np.zeros(noise.shape)
    return light, np.zeros(noise.shape)


# exercise, what the student did, the answer, what the message must say
WRONG = (
    ("filter_pixel", "exp(+)", pixel(lambda t, e: np.exp(t @ e)), "the sign of the exponent is wrong"),
    ("filter_pixel", "normalised", pixel(lambda t, e: weigh(t, e) / weigh(t, e).sum()), "normalised: that comes later"),
    ("filter_pixel", "half", pixel(lambda t, e: weigh(t / 2, e)), "a 2 is too much"),
    ("filter_pixel", "sigma", pixel(lambda t, e: weigh(1 / (2 * t**2), e)), "theta is taken for sigma"),
    ("filter_pixel", "divided", pixel(lambda t, e: weigh(1 / t, e)), "divided by theta"),
    ("filter_pixel", "theta squared", pixel(lambda t, e: weigh(t**2, e)), "theta is squared"),
    ("filter_pixel", "distances squared", pixel(lambda t, e: weigh(t, e**2)), "sums of squares already"),
    ("filter_pixel", "no theta", pixel(lambda t, e: weigh(np.ones(3), e)), "theta is missing"),
    ("filter_pixel", "bells added", bell_each(lambda one: one.sum(axis=0)), "a bell for each m, added"),
    ("filter_pixel", "bells averaged", bell_each(lambda one: one.mean(axis=0)), "a bell for each m, averaged"),
    ("filter_pixel", "a row each", bell_each(lambda one: one), "one weight for each neighbour"),
    ("filter_pixel", "mean over m", pixel(lambda t, e: weigh(t / 3, e)), "the mean over m"),
    ("filter_pixel", "no exp", pixel(lambda t, e: -(t @ e)), "exp is missing"),
    ("filter_pixel", "order", lambda *g: pixel()(*g)[::-1], "the order is filtered, weights"),
    ("filter_pixel", "not divided", pixel(filtered=lambda w, c: w @ c), "not divided by S"),
    ("filter_pixel", "by n", pixel(filtered=lambda w, c: w @ c / len(w)), "the number of neighbours"),
    ("filter_pixel", "twice", pixel(filtered=lambda w, c: w @ c / w.sum() ** 2), "divided by S twice"),
    ("filter_pixel", "plain mean", pixel(filtered=lambda w, c: c.mean(axis=0)), "the mean without weights"),
    ("filter_pixel", "without i", pixel(filtered=lambda w, c: w[1:] @ c[1:] / w[1:].sum()), "the pixel itself is left"),
    ("filter_pixel", "grey", pixel(filtered=lambda w, c: np.full(3, (w @ c / w.sum()).mean())), "over the channels"),
    ("filter_pixel", "not summed", pixel(filtered=lambda w, c: w[:, None] * c / w.sum()), "are not summed"),
    ("filter_pixel", "one result", lambda *g: pixel()(*g)[0], "2 things are needed"),
    ("filter_pixel", "spoils its input", spoiling_pixel, "modified its input `distances`"),
    ("filter_pixel", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("filtered_error_gradient", "n/2", error_slope(lambda d, c, f, n, e: n / 2 * d / (c**2 + e)), "n / 2 in front"),
    ("filtered_error_gradient", "2n", error_slope(lambda d, c, f, n, e: 2 * n * d / (c**2 + e)), "2 n in front"),
    ("filtered_error_gradient", "no spp", error_slope(lambda d, c, f, n, e: d / (c**2 + e)), "the spp, is missing"),
    ("filtered_error_gradient", "2", error_slope(lambda d, c, f, n, e: 2 * d / (c**2 + e)), "n and 1/2 are missing"),
    ("filtered_error_gradient", "sign", error_slope(lambda d, c, f, n, e: -n * d / (c**2 + e)), "the sign is flipped"),
    ("filtered_error_gradient", "E", error_slope(lambda d, c, f, n, e: n / 2 * d**2 / (c**2 + e)), "that is E itself"),
    ("filtered_error_gradient", "square", error_slope(lambda d, c, f, n, e: n * d**2 / (c**2 + e)), "the square goes"),
    ("filtered_error_gradient", "size", error_slope(lambda d, c, f, n, e: n * np.abs(d) / (c**2 + e)), "is lost"),
    (
        "filtered_error_gradient",
        "by c_hat",
        error_slope(lambda d, c, f, n, e: n * d / (f**2 + e)),
        "it is the reference",
    ),
    ("filtered_error_gradient", "no c_hat", error_slope(lambda d, c, f, n, e: -n * c / (c**2 + e)), "c_hat is missing"),
    ("filtered_error_gradient", "no epsilon", error_slope(lambda d, c, f, n, e: n * d / c**2), "epsilon is missing"),
    ("filtered_error_gradient", "0.01", error_slope(lambda d, c, f, n, e: n * d / (c**2 + 0.01)), "another constant"),
    ("filtered_error_gradient", "c", error_slope(lambda d, c, f, n, e: n * d / (c + e)), "c is squared"),
    ("filtered_error_gradient", "quotient", error_slope(lambda d, c, f, n, e: n * d / (c**2 + e) ** 2), "is squared"),
    ("filtered_error_gradient", "absolute", error_slope(lambda d, c, f, n, e: n * d), "the error is relative"),
    ("filtered_error_gradient", "mean", error_slope(lambda d, c, f, n, e: n * d / (c**2 + e) / 3), "the mean over the"),
    ("filtered_error_gradient", "sum", error_slope(lambda d, c, f, n, e: np.sum(n * d / (c**2 + e))), "of its own"),
    ("filtered_error_gradient", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("filtered_by_theta", "sign", lambda *g: -right_slopes(*g), "the sign is flipped"),
    ("filtered_by_theta", "no S", by_theta(lambda w, s, e, c, f, t: -(w * e) @ (c - f)), "1 / S is missing"),
    (
        "filtered_by_theta",
        "S twice",
        by_theta(lambda w, s, e, c, f, t: -(w * e) @ (c - f) / s**2),
        "divided by S twice",
    ),
    (
        "filtered_by_theta",
        "by n",
        by_theta(lambda w, s, e, c, f, t: -(w * e) @ (c - f) / len(w)),
        "number of neighbours",
    ),
    ("filtered_by_theta", "no c_hat", by_theta(lambda w, s, e, c, f, t: -(w * e) @ c / s), "S changes with theta too"),
    ("filtered_by_theta", "T alone", by_theta(lambda w, s, e, c, f, t: -(w * e) @ c), "sum w c alone"),
    ("filtered_by_theta", "own colour", by_theta(lambda w, s, e, c, f, t: -(w * e) @ (c - c[0]) / s), "own colour"),
    (
        "filtered_by_theta",
        "plain mean",
        by_theta(lambda w, s, e, c, f, t: -(w * e) @ (c - c.mean(0)) / s),
        "plain mean",
    ),
    ("filtered_by_theta", "no w", by_theta(lambda w, s, e, c, f, t: -e @ (c - f) / s), "the weights w_j are missing"),
    (
        "filtered_by_theta",
        "no E",
        by_theta(lambda w, s, e, c, f, t: -np.tile(w, (3, 1)) @ (c - f) / s),
        "distances E_mj",
    ),
    ("filtered_by_theta", "transposed", lambda *g: right_slopes(*g).T, "transposed: a row for each theta"),
    ("filtered_by_theta", "log theta", lambda t, e, c: right_slopes(t, e, c) * t[:, None], "log theta"),
    (
        "filtered_by_theta",
        "sigma",
        lambda t, e, c: -right_slopes(t, e, c) * (2 * t[:, None]) ** 1.5,
        "respect to sigma",
    ),
    ("filtered_by_theta", "half", lambda *g: right_slopes(*g) / 2, "there is no 1/2"),
    ("filtered_by_theta", "twice", lambda *g: 2 * right_slopes(*g), "there is no square"),
    ("filtered_by_theta", "channels", lambda *g: right_slopes(*g).sum(axis=1), "the sum over the channels"),
    ("filtered_by_theta", "thetas", lambda *g: right_slopes(*g).sum(axis=0), "the sum over theta"),
    (
        "filtered_by_theta",
        "not summed",
        by_theta(lambda w, s, e, c, f, t: -np.einsum("n,mn,nq->nmq", w, e, c - f) / s),
        "the sum over the neighbours",
    ),
    ("filtered_by_theta", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("which_way", "A", "--0-+", "nearer to its neighbours"),
    ("which_way", "B", ("+", "+", "0", "-", "+"), "keeps it out"),
    ("which_way", "C", "+---+", "two pixels of one paint"),
    ("which_way", "D", "+-0++", "if only near pixels count"),
    ("which_way", "E", "+-0--", "those that err alike"),
    ("which_way", "four", "+-0-", "5 signs are needed"),
    ("which_way", "words", ("up", "down", "0", "-", "+"), "is none of"),
    ("which_way", "a number", 3, "5 signs are needed"),
    ("softplus_link", "local alone", lambda d, t: 1 - np.exp(-t), "d_theta is missing"),
    ("softplus_link", "added", lambda d, t: d + 1 - np.exp(-t), "the chain rule multiplies"),
    ("softplus_link", "e^-theta", lambda d, t: d * np.exp(-t), "1 minus it is the slope"),
    ("softplus_link", "sigmoid of theta", lambda d, t: d / (1 + np.exp(-t)), "theta is not z"),
    ("softplus_link", "s (1 - s)", lambda d, t: d * np.exp(-t) * (1 - np.exp(-t)), "the slope of the sigmoid"),
    ("softplus_link", "theta (1 - theta)", lambda d, t: d * t * (1 - t), "the sigmoid's rule"),
    ("softplus_link", "e^theta", lambda d, t: d * (1 - np.exp(t)), "a sign in the exponent"),
    ("softplus_link", "1 + e^-theta", lambda d, t: d * (1 + np.exp(-t)), "a sign is wrong"),
    ("softplus_link", "divided", lambda d, t: d / (1 - np.exp(-t)), "divided by the slope"),
    ("softplus_link", "sign", lambda d, t: d * np.expm1(-t), "softplus rises"),
    ("softplus_link", "theta", lambda d, t: d * t, "multiplied by theta"),
    ("softplus_link", "once more", lambda d, t: d * np.logaddexp(0, t), "applied once more"),
    ("softplus_link", "unchanged", lambda d, t: d.copy(), "unchanged"),
    ("softplus_link", "z", lambda d, t: np.log(np.exp(t) - 1), "that is z"),
    ("softplus_link", "sum", lambda d, t: (d * (1 - np.exp(-t))).sum(axis=0), "the sum over the pixels"),
    ("softplus_link", "mean", lambda d, t: d * (1 - np.exp(-t)) / len(t), "the mean over the pixels"),
    ("softplus_link", "by z", by_z, "NumPy warns on the way"),
    ("softplus_link", "by a ratio", by_ratio, "z is not needed"),
    ("softplus_link", "returns nothing", lambda d, t: None, "is the `return` missing"),
    ("chain_rule", "sum of errors", chain(error=lambda each, n, spp: sum(each)), "E of five pixels: the sum over"),
    ("chain_rule", "no 1/2", chain(error=lambda each, n, spp: 2 * np.mean(each)), "1/2 is missing"),
    ("chain_rule", "no spp", chain(error=lambda each, n, spp: np.mean(each) / spp), "n, the spp, is missing"),
    ("chain_rule", "no n/2", chain(error=lambda each, n, spp: np.mean(each) / spp * 2), "n/2 is missing"),
    ("chain_rule", "last", chain(error=lambda each, n, spp: each[-1]), "the last pixel alone"),
    ("chain_rule", "last by n", chain(error=lambda each, n, spp: each[-1] / n), "the last pixel alone, divided"),
    ("chain_rule", "early return", early_return, "a `return` inside the loop"),
    ("chain_rule", "channels", chain(error=lambda each, n, spp: np.mean(each) / 3), "the mean over the channels"),
    ("chain_rule", "0.01", fixed_epsilon, "epsilon is another constant"),
    ("chain_rule", "no softplus", chain_of_sums, "softplus is missing between"),
    ("chain_rule", "no bias", chain(start=lambda w, b, x: x @ w.T), "the bias is missing"),
    ("chain_rule", "sums", chain(average=False), "E is their mean, and so is its gradient"),
    ("chain_rule", "no link", chain(link=lambda d, t: d), "the link is missing"),
    ("chain_rule", "link twice", chain(link=lambda d, t: d * (1 - np.exp(-t)) ** 2), "the link is there twice"),
    ("chain_rule", "sigmoid of theta", chain(link=lambda d, t: d / (1 + np.exp(-t))), "the sigmoid of theta"),
    ("chain_rule", "gradient without spp", chain(arrives=lambda d, spp: d / spp), "n, the spp, is missing"),
    ("chain_rule", "sign", chain(arrives=lambda d, spp: -d), "comes later"),
    (
        "chain_rule",
        "last pixel",
        chain(finish=lambda d, x: (len(x) * np.outer(d[-1], x[-1]), len(x) * d[-1])),
        "add up",
    ),
    ("chain_rule", "last by n", chain(finish=lambda d, x: (np.outer(d[-1], x[-1]), d[-1])), "the last pixel alone"),
    (
        "chain_rule",
        "a matrix a pixel",
        chain(finish=lambda d, x: (len(x) * d[:, :, None] * x[:, None], d.sum(axis=0))),
        "d_weight: the sum over the pixels is missing",
    ),
    ("chain_rule", "d_bias a pixel", chain(finish=lambda d, x: (d.T @ x, len(x) * d)), "the sum over the pixels is"),
    ("chain_rule", "transposed", chain(finish=lambda d, x: (x.T @ d, d.sum(axis=0))), "d_weight: transposed"),
    (
        "chain_rule",
        "no x",
        chain(finish=lambda d, x: (np.tile(d.sum(axis=0)[:, None], (1, x.shape[1])), d.sum(axis=0))),
        "x is missing",
    ),
    (
        "chain_rule",
        "product of means",
        chain(finish=lambda d, x: (np.outer(d.sum(axis=0), x.mean(axis=0)), d.sum(axis=0))),
        "the means of dE/dz and of x",
    ),
    ("chain_rule", "bias times x", chain(finish=lambda d, x: (d.T @ x, np.einsum("im,im->m", d, x))), "always 1"),
    ("chain_rule", "order", lambda *g: right_chain(*g)[::-1], "shape"),
    ("chain_rule", "two results", lambda *g: right_chain(*g)[:2], "3 things are needed"),
    ("chain_rule", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("one_epoch", "climbs", epoch(lambda b, used, now, new, old, g: b + used * new), "it climbs"),
    ("one_epoch", "stands still", epoch(lambda b, *_: b.copy()), "it does not move"),
    ("one_epoch", "times gradient", epoch(lambda b, used, now, new, old, g: b - new * g), "only its sign counts"),
    ("one_epoch", "one way", epoch(lambda b, used, now, new, old, g: b - new), "all go the same way"),
    ("one_epoch", "old step", epoch(lambda b, used, now, new, old, g: b - used * old), "not the new one"),
    ("one_epoch", "moves at once", epoch(lambda b, used, now, new, old, g: b - now * new), "waits for one epoch"),
    ("one_epoch", "grows at first", epoch(stepped=lambda a: np.where(a < 0, 0.5, 1.2)), "the step has grown"),
    ("one_epoch", "shrinks at first", epoch(stepped=lambda a: np.where(a > 0, 1.2, 0.5)), "the step has shrunk"),
    ("one_epoch", "never grows", epoch(stepped=lambda a: np.where(a < 0, 0.5, 1.0)), "it does not grow"),
    ("one_epoch", "never shrinks", epoch(stepped=lambda a: np.where(a > 0, 1.2, 1.0)), "it does not shrink"),
    (
        "one_epoch",
        "exchanged",
        epoch(stepped=lambda a: np.where(a < 0, 1.2, np.where(a > 0, 0.5, 1))),
        "it grows where",
    ),
    ("one_epoch", "constant step", epoch(stepped=np.ones_like), "the state is not used"),
    ("one_epoch", "nothing remembered", epoch(remembered=lambda now, used, old, g: 0 * now), "nothing is remembered"),
    ("one_epoch", "gradient remembered", epoch(remembered=lambda now, used, old, g: g), "the gradient itself"),
    ("one_epoch", "move remembered", epoch(remembered=lambda now, used, old, g: -used), "not that of the move"),
    ("one_epoch", "new sign", epoch(remembered=lambda now, used, old, g: now), "shrinks once more"),
    ("one_epoch", "old sign", epoch(remembered=lambda now, used, old, g: np.where(old == 0, now, old)), "that came in"),
    (
        "one_epoch",
        "state not passed on",
        epoch(after=lambda new, kept, e, p, s, d: (new, s, e)),
        "nothing is remembered",
    ),
    (
        "one_epoch",
        "error after",
        epoch(after=lambda new, kept, e, p, s, d: (new, kept, right_chain(**new, **d)[0])),
        "that is E after the step",
    ),
    ("one_epoch", "sum", epoch(after=lambda new, kept, e, p, s, d: (new, kept, 3 * e)), "E: the sum over the pixels"),
    ("one_epoch", "weight alone", epoch(after=only_weight), "bias after one epoch: it does not move"),
    ("one_epoch", "spoils parameters", epoch(spoil=True), "modified its input `parameters`"),
    ("one_epoch", "lists", epoch(after=lambda new, kept, e, *_: (list(new.values()), kept, e)), "must be a dict"),
    (
        "one_epoch",
        "steps alone",
        epoch(after=lambda new, kept, e, *_: (new, {name: pair[1] for name, pair in kept.items()}, e)),
        "must be a pair",
    ),
    (
        "one_epoch",
        "step and sign",
        epoch(after=lambda new, kept, e, *_: (new, {name: pair[::-1] for name, pair in kept.items()}, e)),
        "state of weight",
    ),
    ("one_epoch", "two results", lambda *g: right_epoch(*g)[:2], "3 things are needed"),
    ("one_epoch", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("share_of_the_way", "no log", lambda u, f, o: (u - f) / (u - o), "without the logarithm"),
    ("share_of_the_way", "a factor", lambda u, f, o: u / f, "one of the factors"),
    ("share_of_the_way", "what is left", lambda u, f, o: f / u, "what is left of the error"),
    ("share_of_the_way", "not divided", lambda u, f, o: np.log(u / f), "the whole way"),
    ("share_of_the_way", "upside down", lambda u, f, o: np.log(u / o) / np.log(u / f), "upside down"),
    ("share_of_the_way", "sign", lambda u, f, o: np.log(f / u) / np.log(u / o), "less error is forward"),
    ("share_of_the_way", "left", lambda u, f, o: np.log(f / o) / np.log(u / o), "the way that is left"),
    ("share_of_the_way", "per cent", lambda u, f, o: 100 * np.log(u / f) / np.log(u / o), "yours 50, expected 0.5"),
    ("share_of_the_way", "clipped", lambda u, f, o: max(0, np.log(u / f) / np.log(u / o)), "do not clip it"),
    ("share_of_the_way", "size", lambda u, f, o: abs(np.log(u / f) / np.log(u / o)), "do not clip it"),
    ("share_of_the_way", "returns nothing", lambda u, f, o: None, "is the `return` missing"),
    ("group_ablation", "only", ablation(lambda t, i, k: np.where(i == k, t, 0)), "it alone must be left out"),
    ("group_ablation", "cumulative", ablation(lambda t, i, k: np.where(i > k, t, 0)), "stay out"),
    ("group_ablation", "large", ablation(lambda t, i, k: np.where(i == k, 1e8, t)), "0 leaves it out"),
    ("group_ablation", "nothing", ablation(lambda t, i, k: t), "nothing is left out"),
    ("group_ablation", "difference", ablation(change=lambda found, whole: found - whole), "the difference to"),
    ("group_ablation", "ratio", ablation(change=lambda found, whole: found / whole), "the ratio to"),
    (
        "group_ablation",
        "sum over pixels",
        ablation(error=lambda f, c: np.sum(np.mean((f - c) ** 2 / (c**2 + 0.01), axis=1))),
        "the sum over the pixels",
    ),
    (
        "group_ablation",
        "sum over channels",
        ablation(error=lambda f, c: np.mean(np.sum((f - c) ** 2 / (c**2 + 0.01), axis=1))),
        "the sum over the channels",
    ),
    ("group_ablation", "sum", ablation(error=lambda f, c: np.sum((f - c) ** 2 / (c**2 + 0.01))), "pixels and channels"),
    ("group_ablation", "spoils theta", spoiling_ablation, "modified its input `theta`"),
    ("group_ablation", "smallest", with_pick(lambda errors, given: int(np.argmin(errors))), "nobody misses it"),
    ("group_ablation", "largest theta", with_pick(lambda errors, given: int(np.argmax(given[0]))), "is no proof"),
    ("group_ablation", "its error", with_pick(lambda errors, given: errors.max()), "that is the error itself"),
    ("group_ablation", "an array", with_pick(lambda errors, given: np.argsort(errors)), "most"),
    ("group_ablation", "errors alone", lambda *g: right_ablation(*g)[0], "2 things are needed"),
    ("group_ablation", "returns nothing", lambda *g: None, "is the `return` missing"),
    ("blind_spot", "the same", lambda noise: (board(noise.shape), board(noise.shape)), "Are they the same?"),
    ("blind_spot", "both flat", lambda noise: (0 * noise, 0 * noise + 3), "Are both flat"),
    ("blind_spot", "both rough", lambda noise: (board(noise.shape), board(noise.shape, 5)), "do both have details"),
    ("blind_spot", "too faint", lambda noise: (0 * noise, board(noise.shape, 0.5, 0.52)), "more than 4 is needed"),
    ("blind_spot", "negative", lambda noise: (0 * noise, board(noise.shape, -1)), "light has none"),
    ("blind_spot", "infinite", lambda noise: (0 * noise, board(noise.shape, 0, np.inf)), "must be finite"),
    ("blind_spot", "one light", lambda noise: board(noise.shape), "2 things are needed"),
    ("blind_spot", "colours", lambda noise: (0 * noise, np.zeros((*noise.shape, 3))), "second light"),
    ("blind_spot", "numbers", lambda noise: (0.0, 1.0), "first light"),
    ("blind_spot", "spoils the noise", lambda noise: (noise.__iadd__(9), board(noise.shape)), "modified its input"),
    ("blind_spot", "returns nothing", lambda noise: None, "is the `return` missing"),
)
RIGHT = {
    "filter_pixel": pixel(),
    "filtered_error_gradient": right_error,
    "filtered_by_theta": right_slopes,
    "which_way": "+-0-+",
    "softplus_link": lambda d, t: d * (1 - np.exp(-t)),
    "chain_rule": right_chain,
    "one_epoch": right_epoch,
    "share_of_the_way": lambda u, f, o: (np.log(u) - np.log(f)) / (np.log(u) - np.log(o)),
    "group_ablation": right_ablation,
    "blind_spot": lambda noise: (0 * noise, board(noise.shape)),
}
OTHER_IDEAS = (
    ("filter_pixel", "a list of weights", lambda t, e, c: (pixel()(t, e, c)[0], weigh(t, e).tolist())),
    ("filtered_by_theta", "covariance", centred),
    ("filtered_by_theta", "quotient rule", quotient),
    ("which_way", "a tuple", ("+", "−", 0, "-", "+")),
    ("softplus_link", "expm1", lambda d, t: -d * np.expm1(-t)),
    ("share_of_the_way", "another base", lambda u, f, o: np.log10(u / f) / np.log10(u / o)),
    ("group_ablation", "a NumPy number", with_pick(lambda errors, given: np.int64(np.argmax(errors)))),
    ("blind_spot", "stripes", stripes),
    ("one_epoch", "lists for pairs", lambda *g: _with_lists(*right_epoch(*g))),
)


def _with_lists(parameters, state, error):
    return parameters, {name: list(pair) for name, pair in state.items()}, error


@pytest.mark.parametrize("exercise", RIGHT)
def test_a_right_answer_earns_every_point(exercise):
    assert_earns_every_point(exercise, RIGHT[exercise])


@pytest.mark.parametrize(("exercise", "idea", "answer"), OTHER_IDEAS, ids=[f"{e}: {i}" for e, i, _ in OTHER_IDEAS])
def test_every_right_idea_earns_every_point(exercise, idea, answer):
    assert_earns_every_point(exercise, answer)


@pytest.mark.parametrize(("exercise", "mistake", "answer", "words"), WRONG, ids=[f"{e}: {m}" for e, m, *_ in WRONG])
def test_a_public_test_names_the_mistake(exercise, mistake, answer, words):
    assert_mistake_is_named(exercise, mistake, answer, words)


def test_every_exercise_has_a_right_answer_and_wrong_ones():
    names = {name for name, one in EXERCISES.items() if one.chapter == "ch09"}
    assert set(RIGHT) == {exercise for exercise, *_ in WRONG} == names


# --- what the notebook says is what the library says


def test_the_signs_are_those_of_the_library():
    found = []
    for colours, albedo, right, dial in load_answer(NOTEBOOK, "PIXELS").values():
        distances = np.array([(np.arange(7) - 3.0) ** 2, (albedo - albedo[3]) ** 2 / 0.1])
        theta, colours = np.array([0.1, 0.5]), np.repeat(colours[:, np.newaxis], 3, axis=1)
        filtered, _ = filter_pixel(theta, distances, colours)
        d_filtered = filtered_error_gradient(filtered, np.full(3, right), 4, 0.01)
        slope = (filtered_by_theta(theta, distances, colours) @ d_filtered)[("position", "albedo").index(dial)]
        found.append("-0+"[int(np.sign(slope)) + 1])
        assert slope == 0 or abs(slope) > 0.1  # a clear case
    assert tuple(found) == reference("which_way")


@pytest.fixture
def scene(rng):
    """A small image with one group of features, as the filter sees it."""
    image, albedo = rng.random((6, 7, 3)), {"albedo": rng.random((6, 7, 3))}
    left = {"albedo": np.full((6, 7, 3), 0.2)}
    return Primary(image, np.full_like(image, 0.05), albedo, albedo, left, spp=4), rng.random((6, 7, 3))


def test_the_distances_around_a_pixel_are_those_of_the_layer(scene):
    """The notebook's own `around` with the exercise's filter gives what the layer gives."""
    primary, _ = scene
    around = load_answer(NOTEBOOK, "around")
    layer = FilterLayer(primary, radius=2, engine="numpy")
    theta = np.array([0.1, 0.3, 0.7])
    image, _ = layer.forward(np.broadcast_to(theta, layer.shape))
    for y, x in ((0, 0), (3, 3), (5, 2)):
        filtered, _ = reference("filter_pixel")(theta, *around(primary, y, x, 2))
        np.testing.assert_allclose(filtered, image[y, x], rtol=1e-9)


def test_epochs_by_hand_are_epochs_of_the_library(scene, rng):
    """The same parameters after some epochs as with a network, a layer, a loss and RPROP of the library."""
    primary, truth = scene
    around = load_answer(NOTEBOOK, "around")
    windows = [around(primary, y, x, 9) for y in range(6) for x in range(7)]
    x, distances, colours = rng.normal(size=(42, 2)), *(np.array(part) for part in zip(*windows, strict=True))
    data = {"x": x, "distances": distances, "colours": colours, "reference": truth.reshape(-1, 3)}
    parameters = {"weight": rng.normal(size=(3, 2)), "bias": rng.normal(size=3)}
    state = {name: (np.zeros(one.shape), np.full(one.shape, 0.05)) for name, one in parameters.items()}
    network = MLP((Linear(parameters["weight"], parameters["bias"]), Softplus()))
    layer, optimizer = FilterLayer(primary, radius=9, engine="numpy"), RPROP(0.05)
    theirs = optimizer.start(network.parameters)
    for _ in range(4):
        parameters, state, error = reference("one_epoch")(parameters, state, data | {"spp": 4, "epsilon": 0.01})
        theta, saved = network.forward(x)
        image, kept = layer.forward(theta.reshape(layer.shape))
        scale = truth**2 + 0.01
        assert error == pytest.approx(2 * np.mean(np.sum((image - truth) ** 2 / scale, axis=-1)))
        d_theta = layer.backward(4 * (image - truth) / scale / 42, kept)
        gradients = network.gradients(d_theta.reshape(42, 3), saved)
        new, theirs = optimizer.step(network.parameters, gradients, theirs)
        network = network.replace(new)
    for name in parameters:
        np.testing.assert_allclose(parameters[name], network.parameters[f"{name}_1"], rtol=1e-9)


def test_features_alone_do_not_know_the_light(rng):
    """What `blind_spot` is about: the paper's secondary features are the same under any light, those with colour are not."""
    flat = {"albedo": np.full((9, 9, 3), 0.8, np.float32)}
    lights = rng.random((2, 9, 9, 3), np.float32)
    walls = [Primary(light, np.full_like(light, 0.1), flat, flat, flat, spp=4) for light in lights]
    np.testing.assert_array_equal(*(secondary_features(wall) for wall in walls))
    assert not np.array_equal(*(secondary_features(wall, colour=True) for wall in walls))
