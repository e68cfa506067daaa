# SPDX-License-Identifier: Apache-2.0
"""Which methods differ significantly? Friedman's test and Holm's procedure over the scores of several tests.

10_compare_methods.py
"""

import estancia

scores = {
    "GIST": [0.61, 0.58, 0.70, 0.55, 0.64, 0.60],
    "PHOG": [0.52, 0.50, 0.66, 0.49, 0.57, 0.58],
    "CNN labels": [0.83, 0.80, 0.85, 0.78, 0.88, 0.81],
}
found = estancia.compare_methods(scores, post_hoc="holm")
print(f"Friedman: p = {found.friedman.f_p:.2g}")
for method in found.methods:
    p = "" if method.p is None else f", p = {method.p:.3f} against {found.control}"
    print(f"{method.method}: mean rank {method.mean_rank:.2f}{p}")
