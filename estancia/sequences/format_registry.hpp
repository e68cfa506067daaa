// Format registry: data set formats by type name, detected by content; for sequences and object views.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estancia/core/fail.hpp"
#include "estancia/core/options.hpp"
#include "estancia/files/files.hpp"

namespace estancia::io {

/// One format: whether a path looks like it, and how to open it.
template <class Opened, class Options>
struct Format {
  const char* type;
  const char* explanation;
  bool (*recognizes)(const std::filesystem::path& path);
  Opened (*open)(const std::filesystem::path& path, const Options& options);
};

template <class Formats>
Choices typesOf(const Formats& formats) {
  Choices types;
  for (const auto& format : formats) types.push_back({format.type, format.explanation});
  return types;
}

/// "auto" and the types.
template <class Formats>
Choices typesWithAuto(const Formats& formats) {
  Choices types = typesOf(formats);
  types.insert(types.begin(), {"auto", "detected by content"});
  return types;
}

/// The format of this type, or with "auto" the first that recognizes `path`; null when none does.
template <class Formats>
auto findFormat(const Formats& formats, const std::filesystem::path& path, const std::string& type) {
  const auto found = std::find_if(std::begin(formats), std::end(formats), [&](const auto& format) {
    return type == format.type || (type == "auto" && format.recognizes(path));
  });
  return found == std::end(formats) ? nullptr : &*found;
}

/// The result of `open()`. Exceptions of the file system and of OpenCV become Error.
template <class Open>
auto opened(const std::filesystem::path& path, const Open& open) {
  try {
    return open();
  } catch (const std::filesystem::filesystem_error& e) {
    fail(ErrorCode::fileUnreadable, "{}: cannot be read ({})", printable(path), e.code().message());
  } catch (const cv::Exception& e) {
    fail(ErrorCode::fileUnreadable, "{}: OpenCV cannot read it ({})", printable(path), printable(e.err));
  }
}

/// A Sequence or ObjectViews whose entries are all known when it is opened.
template <class Base, class Entry>
class Listed : public Base {
 public:
  std::string name() const final { return name_; }
  std::size_t size() const final { return entries_.size(); }
  void warn(std::string sentence) { this->warnings_.push_back(std::move(sentence)); }

 protected:
  explicit Listed(std::string name) : name_(std::move(name)) {}

  std::string name_;
  std::vector<Entry> entries_;
};

}  // namespace estancia::io
