# Writes r_rank_tests.csv, what R says about the example of Demšar, JMLR 7 (2006), Table 6: the area under the curve of
# four variants of C4.5 on 14 data sets, one variant a column.
#
#     Rscript tests/stats/r_rank_tests.R > tests/stats/r_rank_tests.csv     (r-base-core 4.2 of Debian 12)
auc <- matrix(c(
  0.763, 0.768, 0.771, 0.798,
  0.599, 0.591, 0.590, 0.569,
  0.954, 0.971, 0.968, 0.967,
  0.628, 0.661, 0.654, 0.657,
  0.882, 0.888, 0.886, 0.898,
  0.936, 0.931, 0.916, 0.931,
  0.661, 0.668, 0.609, 0.685,
  0.583, 0.583, 0.563, 0.625,
  0.775, 0.838, 0.866, 0.875,
  1.000, 1.000, 1.000, 1.000,
  0.940, 0.962, 0.965, 0.962,
  0.619, 0.666, 0.614, 0.669,
  0.972, 0.981, 0.975, 0.975,
  0.957, 0.978, 0.946, 0.970), ncol = 4, byrow = TRUE)
say <- function(name, values) cat(paste(c(name, sprintf("%.15g", values)), collapse = ","), "\n", sep = "")
friedman <- friedman.test(auc)
say("friedman", c(friedman$statistic, friedman$p.value))
chi <- unname(friedman$statistic)
f <- 13 * chi / (14 * 3 - chi)
say("iman_davenport", c(f, pf(f, 3, 39, lower.tail = FALSE)))
ranks <- colMeans(t(apply(-auc, 1, rank)))
say("mean_ranks", ranks)
p <- 2 * pnorm(-abs((ranks[1] - ranks[2:4]) / sqrt(4 * 5 / (6 * 14))))
say("p", p)
say("holm", p.adjust(p, "holm"))
# In thousandths, so that equal differences are ties.
thousandths <- round(1000 * auc)
wilcoxon <- suppressWarnings(wilcox.test(thousandths[, 1], thousandths[, 2], paired = TRUE, exact = FALSE, correct = FALSE))
say("wilcoxon", c(wilcoxon$statistic, wilcoxon$p.value))
exact <- wilcox.test(c(1, 2, 3, 4, 5, 6, 7, 8, -9), paired = FALSE, exact = TRUE)
say("wilcoxon_exact", c(exact$statistic, exact$p.value))
say("nemenyi_quantiles", qtukey(0.05, 2:20, Inf, lower.tail = FALSE) / sqrt(2))
say("nemenyi_p", ptukey(abs(ranks[1] - ranks[2:4]) / sqrt(4 * 5 / (6 * 14)) * sqrt(2), 4, Inf, lower.tail = FALSE))
