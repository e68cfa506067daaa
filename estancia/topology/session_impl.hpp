// Mapping session implementation: a map file, its mapper, and what labels images. Private.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <exception>

#include "estancia/topology/session.hpp"
#include "estancia/topology/store.hpp"

namespace estancia {

struct MappingSession::Impl {
  MapStore store;
  Mapper mapper;
  Labeler* labeler = nullptr;
  std::chrono::steady_clock::time_point lastWritten = std::chrono::steady_clock::now();
  /// In flight when the session began.
  int exceptions = std::uncaught_exceptions();
  bool finished = true;

  /// Without writing.
  int add(const Frame& frame, DescriptorView descriptor, const Image& image);
  void correct(const std::vector<Correction>& corrections);
  void writeWhenDue();
  /// What has changed since the last time.
  void write();
  const MapStore& written();
};

/// The mapper that a map file was made with, as it was at the last commit.
Mapper restoreMapper(const MapStore& store);

}  // namespace estancia
