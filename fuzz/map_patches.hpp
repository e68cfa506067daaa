// Hostile maps: a whole map file, some values of which are replaced, as SQLite would stop nearly all else.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace estancia::fuzz {

/// Replaces values of the tables of the map whose file is `whole`, as `bytes` encodes, and writes it as a
/// file of folder(): parts(), each of which is four bytes, for table, column, row and type (integer, real,
/// text, blob, null, the row is removed, or bytes inside of the value are replaced), and the value; for bytes
/// inside of it, where (two bytes, wraps around) and what.
std::filesystem::path patchedMap(const std::string& whole, std::string_view bytes);

}  // namespace estancia::fuzz
