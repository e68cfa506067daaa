#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Label priors: what a network says of images of many places, for the first minutes of every map.

  models/priors/make_prior.py LABELS.npy -o models/priors/NAME.prior --about "..."

LABELS.npy comes from `estancia label SEQ -o LABELS.npy`. SEQ must show many places, neighbors in it the same place at
most SPAN images long. The committed priors are made of NYU Depth V2 (1,173 images of homes, offices and shops; Silberman
et al. 2012), which no measurement of maps uses:

  estancia label nyuv2_half -o nyu.npy --model inception-v3
  models/priors/make_prior.py nyu.npy -o models/priors/imagenet.prior --about "Inception v3 on NYU Depth V2"

estancia/stats/label_prior.hpp says what the numbers are and how they are used.
"""
import argparse
import pathlib

import numpy

FLOOR = 1e-7  # clrFloor, estancia/stats/distance.hpp
SPAN = 60     # images that may show one place


def standardized(ratios: numpy.ndarray) -> numpy.ndarray:
    """As LabelScale does it, without a prior: unit vectors."""
    count = len(ratios)
    center = ratios.mean(0) * count / (count + 20)
    variance = ratios.var(0)
    typical = (variance**2).sum() / variance.sum()
    weight = numpy.sqrt(variance) / (variance + typical * (0.01 + 1 / (count + 1)))
    vectors = (ratios - center) * weight
    return vectors / numpy.linalg.norm(vectors, axis=1, keepdims=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("labels", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True)
    parser.add_argument("--about", required=True)
    arguments = parser.parse_args()
    probabilities = numpy.load(arguments.labels).astype(numpy.float64)
    words = arguments.labels.with_suffix(".labels.txt").read_text().splitlines()
    if len(words) != probabilities.shape[1]:
        raise SystemExit(f"{arguments.labels}: {probabilities.shape[1]} columns, but {len(words)} labels")
    logarithms = numpy.log(probabilities + FLOOR)
    ratios = logarithms - logarithms.mean(1, keepdims=True)
    vectors = standardized(ratios)
    first, second = numpy.triu_indices(len(vectors), SPAN)
    distances = (1 - vectors @ vectors.T)[first, second]
    gram = vectors @ vectors.T / len(vectors)
    dimensions = numpy.trace(gram) ** 2 / (gram**2).sum()
    lines = [
        "estancia-label-prior 1",
        f"# {arguments.about}; models/priors/make_prior.py",
        f"images {len(vectors)}",
        "distances " + " ".join(f"{value:.3f}" for value in numpy.quantile(distances, numpy.arange(0, 101) / 100)),
        f"dimensions {dimensions:.1f}",
    ]
    spread = ratios.std(0)
    lines += [f"{c:.2f}\t{s:.2f}\t{word}" for c, s, word in zip(ratios.mean(0), spread, words, strict=True)]
    arguments.output.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
