// Fuzz targets: functions that read hostile bytes, run by libFuzzer and, over their corpora, by the tests.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace estancia::fuzz {

struct Target {
  /// "io.pcd": its room, and what it reads.
  std::string name;
  void (*read)(std::string_view bytes);
};

/// The targets of this program, sorted by name.
std::vector<Target> targets();

/// Reads `bytes`. Error is the one exception that a target may end with. Throws std::logic_error when one
/// of its messages could not be shown as it is: control characters, or too long.
void run(const Target& target, std::string_view bytes);

struct Registration {
  Registration(std::string name, void (*read)(std::string_view bytes));
};

/// FUZZ_TARGET(io, pcd) { … }, in this namespace, reads `bytes`.
#define FUZZ_TARGET(room, format)                                                               \
  static void room##_##format(std::string_view bytes);                                          \
  static const Registration room##_##format##_registration{#room "." #format, room##_##format}; \
  static void room##_##format(std::string_view bytes)

/// A folder of this process, removed at its end.
const std::filesystem::path& folder();

/// Writes the bytes as a file of the folder, replacing the one of the last run.
std::filesystem::path inputFile(const std::string& name, std::string_view bytes);

/// `bytes` with some inside of it replaced, as `how` encodes: where (two bytes, wraps around) and what.
std::string withBytesReplaced(std::string bytes, std::string_view how);

/// The parts of an input that stands for several files or values: what lies between lines "%%". Always as
/// many as asked for; those that are missing are empty.
std::vector<std::string_view> parts(std::string_view bytes, std::size_t count);

}  // namespace estancia::fuzz
