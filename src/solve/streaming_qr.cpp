#include "rivid/solve/streaming_qr.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <utility>

#include "checksum.hpp"
#include "rivid/error.hpp"
#include "rivid/input.hpp"
#include "rivid/text.hpp"
#include "solve/householder_kernel.hpp"

namespace rivid {

namespace {

using detail::block_rows;
using detail::block_stride;
static_assert(StreamingQr::most_rows == block_rows);

const detail::HouseholderKernel& kernel() {
  static const detail::HouseholderKernel& once = detail::kernel_for<detail::HouseholderKernel>();
  return once;
}

Index padded(Index columns) {
  return (columns + detail::panel_columns - 1) / detail::panel_columns * detail::panel_columns;
}

std::string size_text(const Eigen::Ref<const Matrix>& matrix) {
  return "(" + std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()) + ")";
}

bool all_within(const Eigen::Ref<const Matrix>& matrix) {
  for (Index c = 0; c < matrix.cols(); ++c) {
    if (!kernel().all_within(matrix.col(c).data(), matrix.rows(), StreamingQr::largest)) {
      return false;
    }
  }
  return true;
}

// Copies rows of a matrix below those that wait; whether all entries are fit to be added.
bool gather(const Eigen::Ref<const Matrix>& matrix, Index first, Index count, double* to) {
  bool within = true;
  for (Index c = 0; c < matrix.cols(); ++c) {
    const Index next = std::min(c + 1, matrix.cols() - 1);
    within = kernel().copy_within(matrix.col(c).data() + first, count, StreamingQr::largest,
                                  to + c * block_stride, matrix.col(next).data() + first) &&
             within;
  }
  return within;
}

}  // namespace

StreamingQr::StreamingQr(Index columns, Index carried) : columns_(columns), carried_(carried) {
  if (columns < 0 || carried < 1) {
    throw InputError("StreamingQr: " + std::to_string(columns) + " columns and " + std::to_string(carried) +
                     " carried ones; at least 0 columns and 1 carried one, which is Y, are needed");
  }
  state_.triangle = Matrix::Zero(padded(columns), columns + carried);
  state_.unreachable = Vector::Zero(carried);
  state_.sums = Vector::Zero(columns + carried);
}

StreamingQr::StreamingQr(const StreamingQr& other)
    : columns_(other.columns_), carried_(other.carried_), rows_(other.rows_), state_(other.copied()) {}

StreamingQr::StreamingQr(StreamingQr&& other) noexcept
    : columns_(std::exchange(other.columns_, 0)),
      carried_(std::exchange(other.carried_, 0)),
      rows_(std::exchange(other.rows_, 0)),
      state_(std::move(other.state_)) {}

StreamingQr& StreamingQr::operator=(const StreamingQr& other) {
  if (this != &other) {
    *this = StreamingQr(other);
  }
  return *this;
}

StreamingQr& StreamingQr::operator=(StreamingQr&& other) noexcept {
  if (this != &other) {
    columns_ = std::exchange(other.columns_, 0);
    carried_ = std::exchange(other.carried_, 0);
    rows_ = std::exchange(other.rows_, 0);
    state_ = std::move(other.state_);
  }
  return *this;
}

StreamingQr::State StreamingQr::copied() const {
  const State& state = settled();
  return {state.triangle, state.unreachable, state.sums, nullptr, 0};
}

const StreamingQr::State& StreamingQr::settled() const {
  if (carried_ == 0) {
    throw InputError("StreamingQr: its rows have been moved to another one; assign a new one to it");
  }
  const std::scoped_lock lock(mutex_);
  eliminate();
  state_.waiting.reset();
  return state_;
}

void StreamingQr::eliminate() const {
  if (state_.waiting_rows == 0) {
    return;
  }
  // Vectors end at multiples of eight rows.
  const Index count = (state_.waiting_rows + 7) / 8 * 8;
  for (Index c = 0; c < columns_ + carried_; ++c) {
    double* const column = state_.waiting.get() + c * block_stride;
    std::fill(column + state_.waiting_rows, column + count, 0.0);
  }
  Vector rest_squares(carried_);
  kernel().eliminate({.columns = columns_,
                      .carried = carried_,
                      .R = state_.triangle.data(),
                      .R_stride = state_.triangle.rows(),
                      .rows = state_.waiting.get(),
                      .row_count = count,
                      .sums = state_.sums.data(),
                      .rest_squares = rest_squares.data()});
  state_.unreachable = (state_.unreachable.array().square() + rest_squares.array()).sqrt();
  state_.waiting_rows = 0;
}

void StreamingQr::add(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Matrix>& Y) {
  if (W.cols() != columns_ || Y.cols() != carried_ || Y.rows() != W.rows()) {
    throw InputError("StreamingQr::add: W is " + size_text(W) + ", Y is " + size_text(Y) + "; W must have " +
                     counted(columns_, "column") + ", Y " + counted(carried_, "column") +
                     " and as many rows as W");
  }
  // Rows that fit in are looked at while they are copied, and do not count before. Others are looked at
  // first.
  const bool fits = W.rows() <= block_rows - state_.waiting_rows;
  if (!fits && !(all_within(W) && all_within(Y))) {
    refuse(W, Y);
  }
  provide();
  for (Index first = 0; first < W.rows();) {
    const Index count = std::min(block_rows - state_.waiting_rows, W.rows() - first);
    double* const to = state_.waiting.get() + state_.waiting_rows;
    const bool within = gather(W, first, count, to) && gather(Y, first, count, to + columns_ * block_stride);
    if (!within) {
      refuse(W, Y);
    }
    state_.waiting_rows += count;
    if (state_.waiting_rows == block_rows) {
      eliminate();
    }
    first += count;
  }
  rows_ += W.rows();
}

void StreamingQr::provide() {
  if (!state_.waiting) {
    const auto size = static_cast<std::size_t>(block_stride * (columns_ + carried_));
    state_.waiting.reset(static_cast<double*>(::operator new(size * sizeof(double), std::align_val_t{64})));
  }
}

RowsRoom StreamingQr::room(Index wanted) {
  if (wanted > most_rows) {
    throw InputError("StreamingQr::room: room for " + std::to_string(wanted) +
                     " rows is wanted, there is at most room for " + std::to_string(most_rows));
  }
  provide();
  if (wanted > block_rows - state_.waiting_rows) {
    eliminate();
  }
  return {{state_.waiting.get() + state_.waiting_rows, block_stride}, block_rows - state_.waiting_rows};
}

void StreamingQr::commit(Index rows) {
  if (rows < 0 || !state_.waiting || rows > block_rows - state_.waiting_rows) {
    throw InputError("StreamingQr::commit: " + std::to_string(rows) + " rows are more than room() gave");
  }
  state_.waiting_rows += rows;
  rows_ += rows;
  if (state_.waiting_rows == block_rows) {
    eliminate();
  }
}

bool StreamingQr::finite() const {
  const State& state = settled();
  // A nan or an infinity goes into the sums, and what is too large into the triangle or what it does not
  // reach.
  return all_within(state.sums) && all_within(state.triangle) && all_within(state.unreachable);
}

void StreamingQr::refuse(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Matrix>& Y) const {
  for (Index r = 0; r < W.rows(); ++r) {
    for (Index c = 0; c < columns_ + carried_; ++c) {
      const double value = c < columns_ ? W(r, c) : Y(r, c - columns_);
      if (!(std::abs(value) <= largest)) {
        const std::string where = c < columns_    ? "column " + std::to_string(c) + " of W"
                                  : carried_ == 1 ? "Y"
                                                  : "column " + std::to_string(c - columns_) + " of Y";
        throw InputError("StreamingQr::add: row " + std::to_string(r) + " of these rows, " + where + ", is " +
                         number(value) + "; entries must be finite and at most " + number(largest));
      }
    }
  }
}

void StreamingQr::merge(const StreamingQr& other) {
  if (other.columns_ != columns_ || other.carried_ != carried_) {
    throw InputError("StreamingQr::merge: the other factor has " + counted(other.columns_, "column") +
                     " and " + std::to_string(other.carried_) + " carried, must have " +
                     counted(columns_, "column") + " and " + std::to_string(carried_) + " carried");
  }
  // A copy, since the other one may be this one.
  const State theirs = other.copied();
  eliminate();
  const Vector sums = state_.sums + theirs.sums;
  // Their triangle counts as rows, but for its sums.
  provide();
  for (Index first = 0; first < columns_; first += block_rows) {
    const Index count = std::min(block_rows, columns_ - first);
    for (Index c = 0; c < columns_ + carried_; ++c) {
      std::copy_n(theirs.triangle.col(c).data() + first, count, state_.waiting.get() + c * block_stride);
    }
    state_.waiting_rows = count;
    eliminate();
  }
  state_.waiting.reset();
  state_.sums = sums;
  for (Index c = 0; c < carried_; ++c) {
    state_.unreachable[c] = std::hypot(state_.unreachable[c], theirs.unreachable[c]);
  }
  rows_ += other.rows_;
}

double StreamingQr::y_norm() const {
  return std::hypot(qt_carried().col(carried_ - 1).norm(), unreachable_norm());
}

void StreamingQr::require_parameters(const char* who, Index count) const {
  if (count != columns_) {
    throw InputError("StreamingQr::" + std::string(who) + ": chi has " + counted(count, "value") +
                     ", must have " + std::to_string(columns_) + ", one a column");
  }
}

double StreamingQr::residual_norm(const Eigen::Ref<const Vector>& chi) const {
  require_parameters("residual_norm", chi.size());
  return std::hypot((qty() - R().triangularView<Eigen::Upper>() * chi).norm(), unreachable_norm());
}

double StreamingQr::residual_sum(const Eigen::Ref<const Vector>& chi) const {
  require_parameters("residual_sum", chi.size());
  return y_sum() - column_sums().dot(chi);
}

namespace {

constexpr std::string_view magic = "rivid-QR";
constexpr std::uint32_t version = 1;                    // of the format
constexpr std::uint32_t byte_order = 0x01020304;        // mark of the format: its bytes tell their order
constexpr std::size_t header_size = 8 + 2 * 4 + 3 * 8;  // [bytes] magic, version and byte_order, three sizes
// Sizes beyond this are damage, and products of smaller ones do not overflow.
constexpr std::uint64_t most_columns = 1'000'000;

// Shifts instead of copied memory: the same bytes on every machine.
template <typename Number>
void put(std::string& out, Number value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    out += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
  }
}

void put(std::string& out, double value) { put(out, std::bit_cast<std::uint64_t>(value)); }

class Reader {
 public:
  explicit Reader(std::string_view content) : content_(content) {}

  template <typename Number>
  Number next() {
    Number value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) {
      value |=
          static_cast<Number>(static_cast<Number>(static_cast<unsigned char>(content_[at_++])) << (8 * i));
    }
    return value;
  }

  void skip(std::size_t count) { at_ += count; }

 private:
  std::string_view content_;
  std::size_t at_ = 0;
};

std::uint64_t content_size(std::uint64_t columns, std::uint64_t carried) {
  const std::uint64_t numbers = columns * (columns + 1) / 2 + columns * carried + carried + columns + carried;
  return header_size + 8 * numbers + 8;
}

}  // namespace

namespace detail {

struct StreamingQrFile {
  // Every number of an accumulator, in the order of the file.
  template <typename Qr, typename See>
  static void each_number(Qr& qr, const See& see) {
    auto& state = qr.state_;
    for (Index c = 0; c < qr.columns_ + qr.carried_; ++c) {
      for (Index r = 0; r < std::min(c + 1, qr.columns_); ++r) {
        see(state.triangle(r, c));
      }
    }
    for (auto& norm : state.unreachable) {
      see(norm);
    }
    for (auto& sum : state.sums) {
      see(sum);
    }
  }

  static void put_numbers(const StreamingQr& qr, std::string& out) {
    static_cast<void>(qr.settled());
    each_number(qr, [&](double value) { put(out, value); });
  }

  static StreamingQr with_numbers(Index columns, Index carried, Index rows, Reader& reader) {
    StreamingQr qr(columns, carried);
    qr.rows_ = rows;
    each_number(qr, [&](double& value) { value = std::bit_cast<double>(reader.next<std::uint64_t>()); });
    return qr;
  }
};

}  // namespace detail

std::string encoded(const StreamingQr& qr) {
  const auto columns = static_cast<std::uint64_t>(qr.columns());
  const auto carried = static_cast<std::uint64_t>(qr.carried());
  std::string out(magic);
  out.reserve(content_size(columns, carried));
  put(out, version);
  put(out, byte_order);
  put(out, columns);
  put(out, carried);
  put(out, static_cast<std::uint64_t>(qr.rows()));
  detail::StreamingQrFile::put_numbers(qr, out);
  put(out, detail::checksum(out));
  return out;
}

StreamingQr decoded_streaming_qr(std::string_view content, std::string_view source) {
  const auto fault = [&](const std::string& what) { return InputError(std::string(source) + ": " + what); };
  if (!content.starts_with(magic.substr(0, std::min(magic.size(), content.size()))) || content.empty()) {
    throw fault("is no factor written by rivid; it must start with \"" + std::string(magic) + "\"");
  }
  if (content.size() < header_size) {
    throw fault("is truncated: " + counted(std::ssize(content), "byte") + " of at least " +
                std::to_string(header_size + 8));
  }
  Reader reader(content);
  reader.skip(magic.size());
  const auto its_version = reader.next<std::uint32_t>();
  const auto its_order = reader.next<std::uint32_t>();
  if (its_order != byte_order) {
    throw fault("has its bytes in another order; the format is little-endian");
  }
  if (its_version != version) {
    throw fault("has version " + std::to_string(its_version) + " of the format; this rivid reads version " +
                std::to_string(version));
  }
  const auto columns = reader.next<std::uint64_t>();
  const auto carried = reader.next<std::uint64_t>();
  const auto rows = reader.next<std::uint64_t>();
  if (columns > most_columns || carried > most_columns || carried < 1 || rows >> 62U != 0) {
    throw fault("is damaged: " + std::to_string(columns) + " columns, " + std::to_string(carried) +
                " carried ones, " + std::to_string(rows) + " rows");
  }
  const std::uint64_t size = content_size(columns, carried);
  if (content.size() != size) {
    throw fault((content.size() < size ? "is truncated: " : "is too long: ") +
                counted(std::ssize(content), "byte") + "; with " + std::to_string(columns) + " + " +
                std::to_string(carried) + " columns it must have " + std::to_string(size));
  }
  Reader end(content.substr(content.size() - 8));
  if (end.next<std::uint64_t>() != detail::checksum(content.substr(0, content.size() - 8))) {
    throw fault("is damaged: its checksum does not fit its content");
  }
  return detail::StreamingQrFile::with_numbers(static_cast<Index>(columns), static_cast<Index>(carried),
                                               static_cast<Index>(rows), reader);
}

StreamingQr read_streaming_qr(const std::filesystem::path& path) {
  return decoded_streaming_qr(read_input(path).bytes(), path.string());
}

}  // namespace rivid
