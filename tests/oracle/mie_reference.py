#!/usr/bin/python3
"""Mie's series in arithmetic of 60 to 160 digits, for the table in mie_test.cpp: an oracle that shares neither
recurrence scheme nor rounding with atmos_tables/optics/mie.cpp. Needs mpmath. Prints n, k, x, Qext, Qsca, Qabs, Qback,
g."""

import mpmath as mp

CASES = [  # (n, k, x)
    ("1.33", "1e-8", "1e-4"),
    ("1.5", "0", "1e-4"),
    ("10", "10", "1e-4"),
    ("1.55", "0.01", "0.01"),
    ("0.75", "0", "0.3"),
    ("1.0001", "0", "5"),
    ("1.33", "1e-10", "20"),
    ("3", "4", "50"),
    ("1.5", "0.02", "317.25"),
    ("0.75", "0", "2000"),
    ("1.33", "1e-6", "20000"),
    ("10", "10", "20000"),
    ("1.5", "0", "100000"),
    ("1.5", "1", "100000"),
]


def efficiencies(n, k, x):
    mp.mp.dps = 160 if float(x) < 1 else 60
    x, m = mp.mpf(float(x)), mp.mpc(float(n), float(k))  # the doubles that the C++ side sees
    terms = int(x + 10 * mp.cbrt(x)) + 12
    start = int(max(terms, abs(m * x) + 12 * mp.cbrt(abs(m * x)))) + 60
    z, d, derivative = m * x, mp.mpc(0), [None] * (terms + 1)
    for order in range(start, 0, -1):
        d = order / z - 1 / (d + order / z)
        if order - 1 <= terms:
            derivative[order - 1] = d
    psi0, psi, chi0, chi = mp.cos(x), mp.sin(x), -mp.sin(x), mp.cos(x)  # orders -1, 0
    a, b = [], []
    for order in range(1, terms + 1):
        psi0, psi = psi, (2 * order - 1) / x * psi - psi0
        chi0, chi = chi, (2 * order - 1) / x * chi - chi0
        xi, xi0 = psi - 1j * chi, psi0 - 1j * chi0
        ca, cb = derivative[order] / m + order / x, derivative[order] * m + order / x
        a.append((ca * psi - psi0) / (ca * xi - xi0))
        b.append((cb * psi - psi0) / (cb * xi - xi0))
    ext = sca = back = g = mp.mpf(0)
    for i in range(terms):
        order = i + 1
        ext += (2 * order + 1) * mp.re(a[i] + b[i])
        sca += (2 * order + 1) * (abs(a[i]) ** 2 + abs(b[i]) ** 2)
        back += (2 * order + 1) * (-1) ** order * (a[i] - b[i])
        g += mp.mpf(2 * order + 1) / (order * (order + 1)) * mp.re(a[i] * mp.conj(b[i]))
        if order < terms:
            g += mp.mpf(order * (order + 2)) / (order + 1) * mp.re(a[i] * mp.conj(a[i + 1]) + b[i] * mp.conj(b[i + 1]))
    scale = 2 / x**2
    return scale * ext, scale * sca, scale * (ext - sca) if mp.im(m) else mp.mpf(0), abs(back) ** 2 / x**2, 2 * g / sca


for case in CASES:
    figures = ", ".join(mp.nstr(mp.re(v), 14) for v in efficiencies(*case))
    print("{" + ", ".join(case) + ",\n " + figures + "},", flush=True)
