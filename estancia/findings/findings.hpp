// Findings: what an experiment found as plain data; experiments write it, the command prints it, pages draw
// it.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace estancia {

/// Numbers in rows and columns, one item that was compared a row.
struct ResultTable {
  enum class Best { none, smallest, largest };
  enum class Form {
    /// 0.05
    fixed,
    /// 5.00e-02, for p-values; "< 1e-300" instead of 0.
    scientific,
    /// "no" for 0, "yes" for everything else.
    yesNo
  };
  struct Column {
    std::string name;
    int decimals = 2;
    /// Which values are highlighted.
    Best best = Best::none;
    Form form = Form::fixed;
    /// Pages point out where its values are above that column's.
    std::optional<std::size_t> beats = {};
    bool operator==(const Column&) const = default;
  };
  struct Row {
    std::string name;
    /// One a column; absent where unknown.
    std::vector<std::optional<double>> values;
    bool operator==(const Row&) const = default;
  };
  std::string title, caption;
  /// Kind of the rows: "model".
  std::string rowsAre;
  std::vector<Column> columns;
  std::vector<Row> rows;
  /// Pages color the cells from 0 to this value; 0: they do not.
  double hottest = 0;

  bool operator==(const ResultTable&) const = default;
};

/// Text of a cell; "–" if the value is absent.
std::string cellText(const ResultTable::Column& column, const std::optional<double>& value);

/// Text of the best cells of a column; values with equal texts are equally good. "" points out none.
std::string bestText(const ResultTable& table, std::size_t column);

/// One curve for each item that was compared, over the same positions.
struct LineChart {
  struct Line {
    std::string name;
    /// One a position.
    std::vector<double> y;
    /// A position that is pointed out, if it is one of x.
    std::optional<double> mark = std::nullopt;
  };
  std::string title, caption, xName, yName;
  /// The y axis; what is not above 0 then lies at its foot.
  bool logarithmic = false;
  /// Ascending.
  std::vector<double> x;
  std::vector<Line> lines;
  /// Positions stand evenly, each named; the y axis begins near the least value.
  bool closeUp = false;
};

/// Shares of a whole, a bar for each item that was compared: wins, ties and losses.
struct StackedBars {
  struct Bar {
    std::string name;
    /// ≥ 0, one a part.
    std::vector<double> values;
  };
  std::string title, caption;
  std::vector<std::string> parts;
  std::vector<Bar> bars;
};

/// A number for each pair of items, as heat.
struct HeatTable {
  std::string title, caption;
  /// Names of rows and columns.
  std::vector<std::string> names;
  /// Row-major; not finite where unknown.
  std::vector<double> values;
  int decimals = 2;

  double at(std::size_t row, std::size_t column) const { return values[row * names.size() + column]; }
};

/// Methods on the axis of their mean ranks, bars joining those that are not found to differ: the critical
/// difference diagram of Demšar, JMLR 7 (2006).
struct RankDiagram {
  struct Method {
    std::string name;
    /// 1 … number of methods.
    double meanRank = 1;
  };
  std::string title, caption;
  /// Best first.
  std::vector<Method> methods;
  /// First and last method that a bar joins.
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  /// Critical difference of Nemenyi's test, drawn as a length.
  std::optional<double> criticalDifference;
  /// Pointed out.
  std::optional<std::size_t> control;
};

/// Images of what was found, each with a line under it.
struct Images {
  struct Image {
    /// A PNG or JPEG.
    std::vector<unsigned char> file;
    std::string caption;
  };
  std::string title, caption;
  std::vector<Image> images;
  /// Few images a row.
  bool wide = false;
};

/// Words of objects, the likelier the larger (thesis Fig. 6.3).
struct WordClouds {
  struct Cloud {
    std::string name;
    /// Weights above 0, descending.
    std::vector<std::pair<std::string, double>> words;
  };
  std::string title, caption;
  std::vector<Cloud> clouds;
};

struct Findings {
  /// The summary is one sentence: the answer.
  std::string title, summary;
  /// Under what circumstances.
  std::vector<std::pair<std::string, std::string>> facts;
  /// Omissions, with their reasons.
  std::vector<std::string> notes;
  std::vector<std::variant<ResultTable, LineChart, StackedBars, HeatTable, RankDiagram, Images, WordClouds>>
      sections;
  /// Results that are also written to files of their own.
  std::vector<Findings> apart;
  /// Name of those files, without an ending.
  std::string file = {};
};

}  // namespace estancia
