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
    std::vector<std::optional<double>> values;  ///< one a column; absent where unknown
    bool operator==(const Row&) const = default;
  };
  std::string title, caption;
  std::string rowsAre;  ///< kind of the rows: "model"
  std::vector<Column> columns;
  std::vector<Row> rows;
  double hottest = 0;  ///< pages color the cells from 0 to this value; 0: they do not

  bool operator==(const ResultTable&) const = default;
};

/// One curve for each item that was compared, over the same positions.
struct LineChart {
  struct Line {
    std::string name;
    std::vector<double> y;  ///< one a position
    /// A position that is pointed out, if it is one of x.
    std::optional<double> mark = std::nullopt;
  };
  std::string title, caption, xName, yName;
  bool logarithmic = false;  ///< the y axis; what is not above 0 then lies at its foot
  std::vector<double> x;     ///< ascending
  std::vector<Line> lines;
  bool closeUp = false;  ///< positions stand evenly, each named; the y axis begins near the least value
};

/// Shares of a whole, a bar for each item that was compared: wins, ties and losses.
struct StackedBars {
  struct Bar {
    std::string name;
    std::vector<double> values;  ///< ≥ 0, one a part
  };
  std::string title, caption;
  std::vector<std::string> parts;
  std::vector<Bar> bars;
};

/// A number for each pair of items, as heat.
struct HeatTable {
  std::string title, caption;
  std::vector<std::string> names;  ///< names of rows and columns
  std::vector<double> values;      ///< row-major; not finite where unknown
  int decimals = 2;

  double at(std::size_t row, std::size_t column) const { return values[row * names.size() + column]; }
};

/// Methods on the axis of their mean ranks, bars joining those that are not found to differ: the critical
/// difference diagram of Demšar, JMLR 7 (2006).
struct RankDiagram {
  struct Method {
    std::string name;
    double meanRank = 1;  ///< 1 … number of methods
  };
  std::string title, caption;
  std::vector<Method> methods;                              ///< best first
  std::vector<std::pair<std::size_t, std::size_t>> groups;  ///< first and last method that a bar joins
  /// Critical difference of Nemenyi's test, drawn as a length.
  std::optional<double> criticalDifference;
  std::optional<std::size_t> control;  ///< pointed out
};

/// Images of what was found, each with a line under it.
struct Images {
  struct Image {
    std::vector<unsigned char> file;  ///< a PNG or JPEG
    std::string caption;
  };
  std::string title, caption;
  std::vector<Image> images;
  bool wide = false;  ///< few images a row
};

/// Words of objects, the likelier the larger (thesis Fig. 6.3).
struct WordClouds {
  struct Cloud {
    std::string name;
    std::vector<std::pair<std::string, double>> words;  ///< weights above 0, descending
  };
  std::string title, caption;
  std::vector<Cloud> clouds;
};

struct Findings {
  std::string title, summary;                              ///< the summary is one sentence: the answer
  std::vector<std::pair<std::string, std::string>> facts;  ///< under what circumstances
  std::vector<std::string> notes;                          ///< omissions, with their reasons
  std::vector<std::variant<ResultTable, LineChart, StackedBars, HeatTable, RankDiagram, Images, WordClouds>>
      sections;
  std::vector<Findings> apart;  ///< results that are also written to files of their own
  std::string file = {};        ///< name of those files, without an ending
};

}  // namespace estancia
