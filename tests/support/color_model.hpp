// A network that names things by their color.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace estancia::test {

/// A model folder whose network says "word 0" of red images and "word 1" of blue ones; "word 2" and "word
/// 3" are rare.
void writeColorModel(const std::filesystem::path& folder);

}  // namespace estancia::test
