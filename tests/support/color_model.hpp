// A network that names things by their color.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace estancia::test {

/// A model folder whose network answers "word 0" for red images and "word 1" for blue ones; "word 2" and
/// "word 3" are rare.
void writeColorModel(const std::filesystem::path& folder);

}  // namespace estancia::test
