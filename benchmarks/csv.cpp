// Reading a log: read_table() against splitting lines with strtod, on the same generated files; RIVID_CSV_MB
// is their size.

#include <benchmark/benchmark.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "process_memory.hpp"
#include "rivid/data/table.hpp"

namespace {

constexpr int columns = 22;  // t and 7 joints of position, velocity, torque

double target_bytes() {
  const char* const megabytes = std::getenv("RIVID_CSV_MB");
  return 1e6 * (megabytes == nullptr ? 60.0 : std::atof(megabytes));
}

// A log of smooth motion with noise, printed with `digits` significant digits; removed at the end of the
// program.
class LogFile {
 public:
  explicit LogFile(int digits)
      : path_(std::filesystem::temp_directory_path() /
              ("rivid_benchmark_" + std::to_string(digits) + ".csv")) {
    std::ofstream out(path_, std::ios::binary);
    for (int c = 0; c < columns; ++c) {
      out << (c == 0 ? "t" : ",c" + std::to_string(c));
    }
    out << '\n';
    std::mt19937_64 generator(20260731);
    std::normal_distribution<double> noise;
    std::array<char, 40> cell{};
    std::string line;
    const double wanted = target_bytes();
    for (int k = 0; bytes_ < wanted; ++k) {
      line.clear();
      for (int c = 0; c < columns; ++c) {
        const double t = 1e-3 * k;
        const double value = c == 0 ? t : std::sin(t * c) * (c > 14 ? 30.0 : 1.5) + 1e-3 * noise(generator);
        const int length = std::snprintf(cell.data(), cell.size(), "%.*g", c == 0 ? 9 : digits, value);
        line += c == 0 ? "" : ",";
        line.append(cell.data(), static_cast<std::size_t>(length));
      }
      line += '\n';
      out << line;
      bytes_ += static_cast<double>(line.size());
    }
    if (!out) {
      throw std::runtime_error("the benchmark's file can not be written");
    }
  }
  ~LogFile() { std::filesystem::remove(path_); }
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;
  LogFile(LogFile&&) = delete;
  LogFile& operator=(LogFile&&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] double bytes() const { return bytes_; }

 private:
  std::filesystem::path path_;
  double bytes_ = 0.0;
};

const LogFile& log_file(int digits) {
  static std::map<int, LogFile> files;
  return files.try_emplace(digits, digits).first->second;
}

std::vector<std::vector<double>> read_with_strtod(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  std::getline(in, line);
  std::vector<std::vector<double>> values(columns);
  while (std::getline(in, line)) {
    const char* p = line.c_str();
    for (std::vector<double>& column : values) {
      char* end = nullptr;
      column.push_back(std::strtod(p, &end));
      p = end + 1;
    }
  }
  return values;
}

template <typename Read>
double seconds(const Read& read) {
  const auto start = std::chrono::steady_clock::now();
  benchmark::DoNotOptimize(read());
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void read_log(benchmark::State& state) {
  const LogFile& file = log_file(static_cast<int>(state.range(0)));
  const double memory =
      rivid::benchmarks::peak_bytes([&] { benchmark::DoNotOptimize(rivid::read_table(file.path())); });
  const double reference = seconds([&] { return read_with_strtod(file.path()); });
  double total = 0.0;
  for (auto _ : state) {
    const double once = seconds([&] { return rivid::read_table(file.path()); });
    state.SetIterationTime(once);
    total += once;
  }
  const double mean = total / static_cast<double>(state.iterations());
  state.counters["MB/s"] = 1e-6 * file.bytes() / mean;
  state.counters["strtod_MB/s"] = 1e-6 * file.bytes() / reference;
  state.counters["ratio"] = reference / mean;
  state.counters["x_memory"] = memory / file.bytes();
}

void read_two_columns(benchmark::State& state) {
  const LogFile& file = log_file(static_cast<int>(state.range(0)));
  const rivid::TableOptions options{.columns = {"t", "c21"}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(rivid::read_table(file.path(), options));
  }
  state.counters["MB/s"] =
      benchmark::Counter(1e-6 * file.bytes(), benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace

BENCHMARK(read_log)->ArgName("digits")->Arg(9)->Arg(17)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(read_two_columns)->ArgName("digits")->Arg(9)->Unit(benchmark::kMillisecond);
