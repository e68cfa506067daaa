# SPDX-License-Identifier: Apache-2.0
"""The peers of bench_describe: FOLDER of images → milliseconds of the processor an image (median) of scikit-image's parts of PHOG and
GIST, one a line: PHOG's edges, orientations and pyramid; GIST's filters by its Gabor kernels and by Fourier transforms."""

import os

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[threads] = "1"

import glob
import sys
import time

import numpy as np
import scipy.fft
from skimage import color, feature, filters, io, transform


def phog(image):
    """Canny and gradients, a histogram of 30 directions a cell, levels 0 to 2."""
    gray = color.rgb2gray(image)
    edges = feature.canny(gray, sigma=2**0.5, low_threshold=0.28, high_threshold=0.7, use_quantiles=True)
    dx, dy = filters.sobel_v(gray)[edges], filters.sobel_h(gray)[edges]
    y, x = np.nonzero(edges)
    bins = (np.arctan2(dy, dx) % (2 * np.pi) / (2 * np.pi) * 30).astype(int) % 30
    votes = np.zeros((4, 4, 30))
    np.add.at(votes, (y * 4 // gray.shape[0], x * 4 // gray.shape[1], bins), np.hypot(dx, dy))
    middle = votes.reshape(2, 2, 2, 2, 30).sum(axis=(1, 3))
    return np.concatenate([votes.sum(axis=(0, 1)), middle.ravel(), votes.ravel()])


def hog(image):
    """feature.hog with 4 × 4, 2 × 2 cells and one: no edges, so less work than PHOG."""
    gray = color.rgb2gray(image)
    cells = [(gray.shape[0] // n, gray.shape[1] // n) for n in (1, 2, 4)]
    return np.concatenate([feature.hog(gray, 30, c, (1, 1)) for c in cells])


def square(image):
    gray = color.rgb2gray(image)
    side = min(gray.shape)
    top, left = (gray.shape[0] - side) // 2, (gray.shape[1] - side) // 2
    return transform.resize(gray[top : top + side, left : left + side], (256, 256)).astype(np.float32)


def blocks(answer):
    return np.abs(answer).reshape(4, 64, 4, 64).mean(axis=(1, 3)).ravel()


def make_bank():
    f = np.fft.fftfreq(320) * 320
    fx, fy = np.meshgrid(f, f)
    for scale in range(4):
        for orientation in range(8):
            angle = np.arctan2(fy, fx) + np.pi / 8 * orientation
            angle -= 2 * np.pi * (angle > np.pi)
            off = np.hypot(fx, fy) / 320 / (0.3 / 1.85**scale) - 1
            yield np.exp(-3.5 * off**2 - 2 * np.pi * angle**2).astype(np.float32)


BANK = list(make_bank())


def gist_by_fourier(image):
    """The 32 filters of GIST on all pixels, by SciPy's Fourier transforms; without its prefilter."""
    spectrum = scipy.fft.fft2(np.pad(square(image), 32, mode="symmetric"))
    return np.concatenate([blocks(scipy.fft.ifft2(spectrum * g)[32:-32, 32:-32]) for g in BANK])


def gabor(image):
    """A bank of the same frequencies and directions by filters.gabor, which convolves with a kernel."""
    gray = square(image)
    answers = []
    for scale in range(4):
        for orientation in range(8):
            real, imaginary = filters.gabor(gray, 0.3 / 1.85**scale, np.pi / 8 * orientation, bandwidth=1.2)
            answers.append(blocks(real + 1j * imaginary))
    return np.concatenate(answers)


def median(work, images):
    times = []
    for image in images:
        start = time.process_time()
        work(image)
        times.append(time.process_time() - start)
    return 1000 * float(np.median(times))


images = [io.imread(name) for name in sorted(glob.glob(sys.argv[1] + "/*.png"))]
for work in (phog, hog, gist_by_fourier, gabor):
    few = images[:3] if work is gabor else images
    work(few[0])
    print(median(work, few))
