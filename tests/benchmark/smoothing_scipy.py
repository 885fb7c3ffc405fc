#!/usr/bin/env python3
"""Smooths the curves of lake_smoothing_benchmark by scipy and prints what Google Benchmark would: processor time of a curve, errors.

smoothing_scipy.py CURVES.csv     needs Debian's python3-scipy; without it, says so in the same form

- smoothing spline: make_smoothing_spline, cubic, its weight by generalised cross-validation (the default).
- UnivariateSpline: cubic, weights 1/sigma, as many knots as it takes until the residuals are what the sigmas say (the defaults);
  and of degree 5.
- Butterworth: as in biomechanics, second order, forward and backward, -3 dB of both together at 6 Hz; speed by central differences.
"""
import csv
import json
import math
import sys
import time

REPEATS = 3


def read_curves(file):
    """By noise and seed: columns of the curve."""
    curves = {}
    with open(file, newline="", encoding="utf-8") as table:
        for row in csv.DictReader(table):
            curve = curves.setdefault(row["noise_deg"], {}).setdefault(row["seed"], {})
            for name in ("time_s", "angle_deg", "speed_deg_s", "measured_deg"):
                curve.setdefault(name, []).append(float(row[name]))
    return curves


def measure(smooth, curves, sigma):
    """Milliseconds per curve, and the root mean square errors of angle and speed."""
    import numpy

    squares = numpy.zeros(2)
    columns = [{name: numpy.array(values) for name, values in curve.items()} for curve in curves]
    smooth(columns[0]["time_s"], columns[0]["measured_deg"], sigma)  # the first call loads what it needs
    begin_s = time.process_time()
    for _ in range(REPEATS):
        results = [smooth(curve["time_s"], curve["measured_deg"], sigma) for curve in columns]
    spent_s = time.process_time() - begin_s
    for curve, (angle, speed) in zip(columns, results):
        squares += numpy.mean((angle - curve["angle_deg"]) ** 2), numpy.mean((speed - curve["speed_deg_s"]) ** 2)
    angle_deg, speed_deg_s = (math.sqrt(square / len(columns)) for square in squares)
    return {"cpu_time": 1000 * spent_s / REPEATS / len(columns), "time_unit": "ms", "angle_deg": angle_deg, "speed_deg_s": speed_deg_s}


def peers():
    import numpy
    from scipy.interpolate import UnivariateSpline, make_smoothing_spline
    from scipy.signal import butter, filtfilt

    def cross_validated(times, values, _):
        spline = make_smoothing_spline(times, values)
        return spline(times), spline.derivative()(times)

    def with_knots(degree):
        def smooth(times, values, sigma):
            spline = UnivariateSpline(times, values, w=numpy.full(len(times), 1 / sigma), k=degree)
            return spline(times), spline.derivative()(times)
        return smooth

    def butterworth(times, values, _):
        cutoff_hz = 6 / (math.sqrt(2) - 1) ** 0.25  # two passes lower a pass's -3 dB by this
        step_s = times[1] - times[0]
        smooth = filtfilt(*butter(2, 2 * cutoff_hz * step_s), values)
        return smooth, numpy.gradient(smooth, step_s)

    return {"make_smoothing_spline": cross_validated, "UnivariateSpline": with_knots(3), "UnivariateSpline k=5": with_knots(5),
            "Butterworth 6 Hz": butterworth}


def main():
    try:
        competitors = peers()
    except ImportError:
        print(json.dumps({"benchmarks": [], "missing": "scipy (1.10 or later) is missing: apt-get install python3-scipy"}))
        return
    print(json.dumps({"benchmarks": [
        {"name": f"Smooth/{name}/{noise}"} | measure(smooth, list(curves.values()), float(noise))
        for noise, curves in read_curves(sys.argv[1]).items() for name, smooth in competitors.items()]}))


if __name__ == "__main__":
    main()
