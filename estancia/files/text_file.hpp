// Text file: whether a file is text, by its first bytes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace estancia::io {

/// Whether there are bytes, and the first 4096 hold no control character but tabs, line ends and form feeds.
/// Images, maps, videos and other binary files have some.
bool isTextFile(const std::filesystem::path& file);

}  // namespace estancia::io
