// SPDX-License-Identifier: Apache-2.0
#include "estancia/classify/pairwise_coupling.hpp"

#include <algorithm>
#include <cmath>

namespace estancia {
namespace {

/// ln(1 + exp x) without overflow.
double softplus(double x) {
  return x > 0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x));
}

}  // namespace

double Sigmoid::operator()(double decision) const {
  const double x = a * decision + b;
  return x >= 0 ? std::exp(-x) / (1 + std::exp(-x)) : 1 / (1 + std::exp(x));
}

Sigmoid fitSigmoid(std::span<const double> decisions, std::span<const char> isFirst,
                   std::span<const double> weights) {
  double first = 0, second = 0;
  std::size_t firsts = 0;
  for (std::size_t i = 0; i < decisions.size(); ++i) {
    (isFirst[i] != 0 ? first : second) += weights[i];
    firsts += isFirst[i] != 0 ? 1 : 0;
  }
  const std::size_t seconds = decisions.size() - firsts;
  if (firsts == 0 || seconds == 0 || !(first > 0) || !(second > 0)) return {};
  const double high = (static_cast<double>(firsts) + 1) / (static_cast<double>(firsts) + 2);
  const double low = 1 / (static_cast<double>(seconds) + 2);
  const auto target = [&](std::size_t i) { return isFirst[i] != 0 ? high : low; };
  const auto loss = [&](const Sigmoid& s) {
    double sum = 0;
    for (std::size_t i = 0; i < decisions.size(); ++i) {
      const double x = s.a * decisions[i] + s.b;
      sum += weights[i] * (softplus(x) - (1 - target(i)) * x);
    }
    return sum;
  };

  Sigmoid sigmoid{0, std::log((second + 1) / (first + 1))};
  double value = loss(sigmoid);
  constexpr int iterations = 100;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    // Newton's method; the ridge keeps the Hessian positive definite.
    double h11 = 1e-12, h22 = 1e-12, h21 = 0, g1 = 0, g2 = 0;
    for (std::size_t i = 0; i < decisions.size(); ++i) {
      const double p = sigmoid(decisions[i]), q = 1 - p, d2 = weights[i] * p * q,
                   d1 = weights[i] * (target(i) - p);
      h11 += decisions[i] * decisions[i] * d2;
      h22 += d2;
      h21 += decisions[i] * d2;
      g1 += decisions[i] * d1;
      g2 += d1;
    }
    if (std::fabs(g1) < 1e-5 && std::fabs(g2) < 1e-5) break;
    const double determinant = h11 * h22 - h21 * h21;
    const double stepA = -(h22 * g1 - h21 * g2) / determinant, stepB = -(h11 * g2 - h21 * g1) / determinant;
    const double slope = g1 * stepA + g2 * stepB;
    double step = 1;
    for (; step >= 1e-10; step /= 2) {
      const Sigmoid next{sigmoid.a + step * stepA, sigmoid.b + step * stepB};
      const double nextValue = loss(next);
      if (nextValue < value + 1e-4 * step * slope) {
        sigmoid = next;
        value = nextValue;
        break;
      }
    }
    if (step < 1e-10) break;
  }
  // Held-out decisions of a few samples may be anti-correlated; a falling sigmoid would then invert every
  // answer. Only the shares of the classes are known then, and that the sign of a decision is right.
  if (sigmoid.a > 0) return {-1, std::log((second + 1) / (first + 1))};
  return sigmoid;
}

std::vector<double> couplePairs(std::span<const double> r, std::size_t k) {
  std::vector<double> q(k * k), p(k, 1 / static_cast<double>(k)), qp(k);
  for (std::size_t t = 0; t < k; ++t)
    for (std::size_t j = 0; j < k; ++j) {
      if (j == t) continue;
      q[t * k + t] += r[j * k + t] * r[j * k + t];
      q[t * k + j] = -r[j * k + t] * r[t * k + j];
    }
  const double epsilon = 0.001 / static_cast<double>(k);
  const int iterations = std::max<int>(100, static_cast<int>(k));
  for (int iteration = 0; iteration < iterations; ++iteration) {
    double pqp = 0;
    for (std::size_t t = 0; t < k; ++t) {
      qp[t] = 0;
      for (std::size_t j = 0; j < k; ++j) qp[t] += q[t * k + j] * p[j];
      pqp += p[t] * qp[t];
    }
    double error = 0;
    for (std::size_t t = 0; t < k; ++t) error = std::max(error, std::fabs(qp[t] - pqp));
    if (error < epsilon) break;
    for (std::size_t t = 0; t < k; ++t) {
      if (!(q[t * k + t] > 0)) continue;
      const double difference = (-qp[t] + pqp) / q[t * k + t];
      p[t] += difference;
      pqp =
          (pqp + difference * (difference * q[t * k + t] + 2 * qp[t])) / (1 + difference) / (1 + difference);
      for (std::size_t j = 0; j < k; ++j) {
        qp[j] = (qp[j] + difference * q[t * k + j]) / (1 + difference);
        p[j] /= 1 + difference;
      }
    }
  }
  double sum = 0;
  for (double& value : p) sum += value = std::max(value, 0.0);
  for (double& value : p) value /= sum;
  return p;
}

}  // namespace estancia
