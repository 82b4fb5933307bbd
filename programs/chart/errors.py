# SPDX-License-Identifier: Apache-2.0
"""How far images are from a reference: the figures of manylight-compare, under the same names.

programs/metrics explains them; here they are again, as arrays make them quick enough for hundreds of images.
"""
import math

import numpy as np

_LUMINANCE = np.array([0.212671, 0.715160, 0.072169])  # Rec. 709, as in core/spectrum.hpp
_WINDOW = 11  # pixels, of SSIM


def dark_term(reference):
    """What keeps black pixels from ruling relative errors: (0.05 mean r)^2."""
    return (0.05 * reference.mean()) ** 2


def measure(image, reference):
    """Figures of one image."""
    difference = image - reference
    squares = difference ** 2
    denominator = reference ** 2 + dark_term(reference)
    relative = np.divide(squares, denominator, out=np.where(squares > 0, math.inf, 0.0), where=denominator > 0)
    per_pixel = np.sort(relative.sum(axis=2).ravel())
    kept = per_pixel[:len(per_pixel) - len(per_pixel) // 1000]
    result = {
        "mean": image.mean(),
        "reference_mean": reference.mean(),
        "rmse": math.sqrt(squares.mean()),
        "rel_mse": relative.mean(),
        "trimmed_rel_mse": kept.mean() / 3,
        "mape": (np.abs(difference) / (np.abs(reference) + 0.01)).mean(),
        "mean_signed_difference": _ratio(difference.mean(), reference.mean()),
    }
    if min(image.shape[:2]) >= _WINDOW:
        result["ssim"] = ssim(image, reference)
    return {name: float(value) for name, value in result.items()}


def _ratio(numerator, denominator):
    if denominator != 0:
        return numerator / denominator
    return 0.0 if numerator == 0 else math.copysign(math.inf, numerator)


def exposure_for(reference):
    """0.18 / mean luminance."""
    mean = (reference @ _LUMINANCE).mean()
    return 0.18 / mean if mean > 0 else 0.0


def tone_mapped(values, exposure):
    """Linear values, times the exposure, for display: v / (1 + v), then sRGB."""
    v = np.maximum(values * exposure, 0)
    v = v / (1 + v)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def _windowed(values):
    """Means under SSIM's window, where it fits."""
    offsets = (np.arange(_WINDOW) - _WINDOW // 2) / 1.5
    weights = np.exp(-0.5 * offsets ** 2)
    weights /= weights.sum()
    rows, columns = (side - _WINDOW + 1 for side in values.shape)
    along = sum(weight * values[:, i:i + columns] for i, weight in enumerate(weights))
    return sum(weight * along[i:i + rows] for i, weight in enumerate(weights))


def ssim(image, reference):
    """Structural similarity of luminance behind the tone curve."""
    exposure = exposure_for(reference)
    x, y = (tone_mapped(values @ _LUMINANCE, exposure) for values in (image, reference))
    c1, c2 = 0.01 ** 2, 0.03 ** 2
    mean_x, mean_y = _windowed(x), _windowed(y)
    means, squares = mean_x * mean_y, mean_x ** 2 + mean_y ** 2
    variances = _windowed(x * x) + _windowed(y * y) - squares
    covariance = _windowed(x * y) - means
    return ((2 * means + c1) * (2 * covariance + c2) / ((squares + c1) * (variances + c2))).mean()


def _parts(gram, runs, left_out=None):
    """Mean square error, variance and bias^2 from inner products, without one run or batch."""
    keep = [i for i in range(len(gram)) if i != left_out]
    k = sum(i < runs for i in keep)
    b = len(keep) - k
    gram = gram[np.ix_(keep, keep)]
    squares = np.trace(gram[:k, :k])
    own, pairs = squares / k, (gram[:k, :k].sum() - squares) / (k * (k - 1))
    truth = 0.0
    if b > 1:
        truth = (gram[k:, k:].sum() - np.trace(gram[k:, k:])) / (b * (b - 1))
    shift = truth - 2 * gram[:k, k:].sum() / (k * b)
    return np.array([own + shift, own - pairs, pairs + shift])


def _jackknife(gram, runs):
    """Variances of _parts: over runs plus over batches."""
    total = np.zeros(3)
    for first, count in ((0, runs), (runs, len(gram) - runs)):
        if count == 2:
            return np.full(3, math.inf)
        if count > 2:
            without = np.array([_parts(gram, runs, first + i) for i in range(count)])
            total += ((without - without.mean(axis=0)) ** 2).sum(axis=0) * (count - 1) / count
    return total


def _estimates(gram, runs):
    values, errors = _parts(gram, runs), np.sqrt(_jackknife(gram, runs))
    return [{"value": float(value), "standard_error": float(error)} for value, error in zip(values, errors)]


def split(runs, batches, relative_noise=0.0):
    """Error of independent runs against independent references, or one image: variance and bias^2.

    One image tells nothing of its noise: `relative_noise` is its relative variance. As it is independent of the runs,
    E[(x - r)^2] holds it beside their variance and bias^2.
    """
    truth = np.mean(batches, axis=0)
    centred = np.array([image - truth for image in [*runs, *batches]]).reshape(len(runs) + len(batches), -1)
    weights = (1 / (truth ** 2 + dark_term(truth))).ravel()
    terms, count = truth.size, len(batches)
    result = {}
    for prefix, gram, noise in (("", centred @ centred.T, 0.0),
                                ("rel_", (centred * weights) @ centred.T, relative_noise)):
        gram /= terms
        names = [prefix + name for name in ("mse", "variance", "bias_squared")]
        result.update(zip(names, _estimates(gram, len(runs))))
        if count > 1:
            noise = np.trace(gram[len(runs):, len(runs):]) / (count * (count - 1))
        else:
            for name in (prefix + "mse", prefix + "bias_squared"):
                result[name]["value"] -= noise
        result[prefix + "reference_variance"] = float(noise)
    means, reference_means = ([image.mean() for image in images] for images in (runs, batches))
    ratio = np.mean(means) / truth.mean()
    noise = np.var(reference_means, ddof=1) / count if count > 1 else 0.0
    variance = np.var(means, ddof=1) / len(runs) + ratio ** 2 * noise
    result["mean_signed_difference"] = {"value": float(ratio - 1),
                                        "standard_error": float(math.sqrt(variance) / abs(truth.mean()))}
    return result


def relative_difference(image, reference):
    """Signed, of luminance: what the difference images show."""
    y, r = image @ _LUMINANCE, reference @ _LUMINANCE
    dark = (0.05 * r.mean()) ** 2
    return (y - r) / np.sqrt(r ** 2 + dark) if r.any() else y - r
