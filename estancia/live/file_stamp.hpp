// File stamp: whether another program has written a map file.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace estancia {

/// Changes when the file is written: also while its newest part still stands beside it (SQLite's WAL). ""
/// where there is none.
std::string fileStamp(const std::filesystem::path& path);

}  // namespace estancia
