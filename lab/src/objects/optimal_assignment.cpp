// SPDX-License-Identifier: Apache-2.0
#include "objects/optimal_assignment.hpp"

#include <algorithm>
#include <limits>
#include <opencv2/core.hpp>

namespace estancia::experiments {
namespace {

/// Kuhn's method by shortest augmenting paths (Jonker and Volgenant, Computing 38, 1987), for no more rows
/// than columns. Row and column 0 stand for none.
class Assignment {
 public:
  explicit Assignment(const cv::Mat_<double>& gain)
      : gain_(gain),
        rowPrice_(static_cast<std::size_t>(gain.rows) + 1),
        columnPrice_(static_cast<std::size_t>(gain.cols) + 1),
        rowOf_(columnPrice_.size()),
        from_(columnPrice_.size()) {
    for (std::size_t row = 1; row < rowPrice_.size(); ++row) add(row);
  }
  const std::vector<std::size_t>& rows() const { return rowOf_; }

 private:
  double cost(std::size_t row, std::size_t column) const {
    return -gain_(static_cast<int>(row) - 1, static_cast<int>(column) - 1) - rowPrice_[row] -
           columnPrice_[column];
  }
  void add(std::size_t row) {
    std::vector<double> distance(columnPrice_.size(), std::numeric_limits<double>::infinity());
    std::vector<char> done(columnPrice_.size());
    rowOf_[0] = row;
    std::size_t column = 0;
    while (rowOf_[column] != 0) {
      done[column] = 1;
      column = step(column, distance, done);
    }
    for (; column != 0; column = from_[column]) rowOf_[column] = rowOf_[from_[column]];
  }
  /// The nearest column that is not done, seen from the done ones; moves the prices by its distance.
  std::size_t step(std::size_t last, std::vector<double>& distance, const std::vector<char>& done) {
    std::size_t nearest = 0;
    for (std::size_t j = 1; j < distance.size(); ++j) {
      if (done[j] != 0) continue;
      if (const double c = cost(rowOf_[last], j); c < distance[j]) {
        distance[j] = c;
        from_[j] = last;
      }
      if (nearest == 0 || distance[j] < distance[nearest]) nearest = j;
    }
    const double by = distance[nearest];
    for (std::size_t j = 0; j < distance.size(); ++j) {
      if (done[j] != 0) {
        rowPrice_[rowOf_[j]] += by;
        columnPrice_[j] -= by;
      } else {
        distance[j] -= by;
      }
    }
    return nearest;
  }

  const cv::Mat_<double>& gain_;
  std::vector<double> rowPrice_, columnPrice_;
  std::vector<std::size_t> rowOf_, from_;
};

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> optimalAssignment(const cv::Mat_<double>& gain) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const bool wide = gain.rows <= gain.cols;
  const cv::Mat_<double> across = wide ? gain : cv::Mat_<double>(gain.t());
  const Assignment assignment(across);
  const auto& rows = assignment.rows();
  for (std::size_t column = 1; column < rows.size(); ++column) {
    if (rows[column] == 0) continue;
    if (wide)
      pairs.emplace_back(rows[column] - 1, column - 1);
    else
      pairs.emplace_back(column - 1, rows[column] - 1);
  }
  std::ranges::sort(pairs);
  return pairs;
}

}  // namespace estancia::experiments
