// NPY files: NumPy matrices of float32 or float64.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "estancia/core/descriptor.hpp"

namespace estancia::io {

/// A matrix in a .npy file, read row by row. Format: numpy/lib/format.py, versions 1 to 3.
class NpyFile {
 public:
  /// Checks the header, and that the file holds exactly the rows that it declares. Throws Error unless the
  /// matrix is float32 or float64, little-endian, C order, of two dimensions.
  explicit NpyFile(const std::filesystem::path& file);

  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  /// The next row, as float64. Throws Error when it cannot be read.
  const std::vector<double>& next();

 private:
  std::string name_;
  std::ifstream stream_;
  std::size_t rows_ = 0, columns_ = 0, bytesPerValue_ = 0;
  std::vector<char> bytes_;
  std::vector<double> row_;
};

/// The bytes of a float32 .npy file, N×L.
std::string npyBytes(const DescriptorMatrix& matrix);

}  // namespace estancia::io
