// CPU cores: how many this process may use, and how many of them are idle.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>

namespace estancia {

/// Cores that this process may use: those of its affinity mask, at most its cgroup's CPU quota (v1 and v2).
/// At least 1. `root` is where /proc and /sys are, for tests.
int usableCores(const std::filesystem::path& root = "/");

/// usableCores() minus those that other processes keep busy, measured over 50 ms. At least 1; all of them if
/// the load is unknown. One thread more than free cores slows a network down.
int freeCores();

/// CPU time of all processes on the cores `cpus`, by the text of /proc/stat [ticks]; -1: one is missing.
long long busyTicks(const std::string& procStat, const std::set<int>& cpus);

}  // namespace estancia
