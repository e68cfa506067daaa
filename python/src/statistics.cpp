// SPDX-License-Identifier: Apache-2.0
// Statistics: rank tests of methods, agreement of clusters with classes, distances and dendrograms.
#include "arrays.hpp"
#include "call.hpp"
#include "estancia/distances/distance.hpp"
#include "estancia/stats/clustering_agreement.hpp"
#include "estancia/stats/linkage.hpp"
#include "estancia/stats/method_comparison.hpp"
#include "estancia/stats/rank_tests.hpp"
#include "options.hpp"
#include "values.hpp"

namespace estancia::python {
namespace {

using Table = std::vector<std::vector<double>>;

py::object friedman(const Table& scores) {
  const FriedmanTest t = friedmanTest(scores);
  return make("FriedmanTest", t.chiSquared, t.degrees, t.p, t.f, t.fP, t.undefined);
}

py::object wilcoxon(const std::vector<double>& a, const std::vector<double>& b) {
  const WilcoxonTest t = wilcoxonTest(a, b);
  return make("WilcoxonTest", t.better, t.worse, t.different, t.exact, t.z, t.p);
}

py::object compareAll(std::vector<std::string> methods, std::vector<std::string> tests, Table scores,
                      const py::dict& given) {
  const MethodComparison found = compareMethods({std::move(methods), std::move(tests), std::move(scores)},
                                                optionsFrom<ComparisonOptions>(given));
  const auto& names = found.scores.methods;
  const auto rows = listOf(found.rows, [&](const MethodComparison::Row& row) {
    return make("MethodRank", names[row.method], row.meanRank, row.p, row.rejected, row.control.wins,
                row.control.ties, row.control.losses);
  });
  const FriedmanTest& t = found.friedman;
  return make("MethodComparison", make("FriedmanTest", t.chiSquared, t.degrees, t.p, t.f, t.fP, t.undefined),
              found.differ, names[found.control], rows, found.criticalDifference);
}

py::object agreement(const std::vector<int>& truth, const std::vector<int>& clusters) {
  const Agreement a = measureAgreement(truth, clusters);
  return make("Agreement", a.homogeneity, a.completeness, a.vMeasure, a.adjustedRandIndex, a.purity);
}

py::array distancesOf(const py::object& array, const std::string& name, const py::object& callback) {
  const Distance distance = getDistance(name);
  DescriptorMatrix rows = matrixOf(array, "rows");
  DescriptorMatrix embedded(rows.labels());
  std::vector<float> row(rows.labels());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    embed(distance.embedding, rows.row(i), row);
    embedded.append(row);
  }
  const Comparison comparison = comparisonFor(distance, Linkage::average);
  const auto progress = makeProgress(callback);
  const CondensedDistances d =
      longCall([&] { return pairwiseDistances(embedded, comparison, 0, *progress); });
  return py::array_t<double>(static_cast<py::ssize_t>(d.values().size()), d.values().data());
}

py::array linkageOf(const py::object& array, std::size_t items, const std::string& name) {
  const auto values = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
  if (!values || static_cast<std::size_t>(values.size()) != items * (items - 1) / 2) {
    PyErr_Clear();
    throw Error(ErrorCode::mismatch, "the distances of n items are n (n - 1) / 2 numbers");
  }
  CondensedDistances distances(items);
  std::copy_n(values.data(), values.size(), distances.values().begin());
  const Linkage linkage = getLinkage(name);
  const Dendrogram tree = longCall([&] { return link(std::move(distances), linkage); });
  py::array_t<double> z({static_cast<py::ssize_t>(tree.merges().size()), py::ssize_t{4}});
  auto* out = z.mutable_data();
  for (const Dendrogram::Merge& merge : tree.merges())
    for (const double value : {static_cast<double>(merge.left), static_cast<double>(merge.right),
                               merge.height, static_cast<double>(merge.size)})
      *out++ = value;
  return z;
}

py::list choicesOf(const Choices& choices) {
  return listOf(choices, [](const Choice& c) { return py::make_tuple(c.name, c.explanation); });
}

}  // namespace

void bindStatistics(py::module_& m) {
  m.def("mean_ranks", [](const Table& scores, bool larger) {
    return meanRanks(scores, larger ? Better::larger : Better::smaller);
  });
  m.def("friedman_test", friedman);
  m.def("wilcoxon_test", wilcoxon);
  m.def("holm_adjusted", [](const std::vector<double>& p) { return holmAdjusted(p); });
  m.def("shaffer_adjusted",
        [](const std::vector<double>& p, std::size_t methods) { return shafferAdjusted(p, methods); });
  m.def("critical_difference", &criticalDifference);
  m.def("compare_methods", compareAll);
  m.def("measure_agreement", agreement);
  m.def("pairwise_distances", distancesOf);
  m.def("linkage", linkageOf);
  m.def("distances", [] { return choicesOf(distances()); });
  m.def("linkages", [] { return choicesOf(linkages()); });
}

}  // namespace estancia::python
