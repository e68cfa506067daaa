// SPDX-License-Identifier: Apache-2.0
#include "fuzz/fuzz_target.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <system_error>

#include "estancia/core/error.hpp"
#include "estancia/core/printable.hpp"

namespace estancia::fuzz {
namespace fs = std::filesystem;
namespace {

std::vector<Target>& registered() {
  static std::vector<Target> all;
  return all;
}

struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "estancia-fuzz-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
    path = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

void requireShown(const std::string& message) {
  constexpr std::size_t longest = 2000;
  if (message.size() > longest) throw std::logic_error("a message is too long: " + message);
  if (printable(message) != message) throw std::logic_error("a message has control characters: " + message);
}

}  // namespace

Registration::Registration(std::string name, void (*read)(std::string_view bytes)) {
  registered().push_back({std::move(name), read});
}

std::vector<Target> targets() {
  std::vector<Target> all = registered();
  std::ranges::sort(all, {}, &Target::name);
  return all;
}

void run(const Target& target, std::string_view bytes) {
  try {
    target.read(bytes);
  } catch (const Error& e) {
    requireShown(e.what());
  }
}

const fs::path& folder() {
  static const Folder folder;
  return folder.path;
}

fs::path inputFile(const std::string& name, std::string_view bytes) {
  fs::path path = folder() / name;
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (file < 0 || write(file, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    throw std::system_error(errno, std::generic_category(), path.string());
  close(file);
  return path;
}

std::string withBytesReplaced(std::string bytes, std::string_view how) {
  if (how.size() < 2 || bytes.empty()) return bytes;
  const auto number = [&](std::size_t i) { return std::size_t{static_cast<unsigned char>(how[i])}; };
  const std::size_t at = (number(0) + 256 * number(1)) % bytes.size();
  const std::string_view with = how.substr(2, bytes.size() - at);
  return bytes.replace(at, with.size(), with);
}

std::vector<std::string_view> parts(std::string_view bytes, std::size_t count) {
  constexpr std::string_view mark = "\n%%\n";
  std::vector<std::string_view> found;
  while (found.size() + 1 < count) {
    const std::size_t at = bytes.find(mark);
    if (at == std::string_view::npos) break;
    found.push_back(bytes.substr(0, at));
    bytes.remove_prefix(at + mark.size());
  }
  found.push_back(bytes);
  found.resize(count);
  return found;
}

}  // namespace estancia::fuzz
