#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <string_view>

#include "rivid/types.hpp"

namespace rivid {

namespace detail {
struct StreamingQrFile;
}

/// Orthogonal factorisation of [W Y] whose rows come block by block: only the triangle R, Qᵀ Y, the residual
/// norm and column sums are kept, so memory does not grow with the number of rows. Rows may come in any
/// blocks, down to single ones, and accumulators of parts of the rows may be merged in any order: the result
/// is that of one factorisation of all rows, to rounding.
///
/// More columns than Y may be carried along. With W eliminated from [V | W Y], Eq. (34) of [RIV] in one pass,
///
///   [V | W Y] = Q [R_VV | R_VW r_VY; 0 | …],   R_VW χ = r_VY,
///
/// `StreamingQr(b, b + 1)` gets V as the first and [W Y] as the second argument of add(); then R() is R_VV,
/// qt_carried() is [R_VW r_VY] and qty() is r_VY.
///
/// Rows are gathered and eliminated 512 at a time, so how they are split into blocks changes nothing, bit for
/// bit; a reader finds all rows eliminated. While rows wait they take 4 kB a column; reading gives that
/// memory back. Reading from several threads at once is safe. One whose rows were moved to another throws
/// InputError where it is read.
class StreamingQr {
 public:
  /// Largest magnitude that is accepted, so that squares and their sums stay finite. At the other end, what
  /// is left of a column in a block counts as zero where its norm is below 1e-154.
  static constexpr double largest = 1e150;
  /// Rows that are eliminated at a time.
  static constexpr Index most_rows = 512;

  /// @param columns  to eliminate, those of W, at least 0
  /// @param carried  columns that go along, at least 1; the last one is Y
  explicit StreamingQr(Index columns, Index carried = 1);

  StreamingQr(const StreamingQr& other);
  StreamingQr(StreamingQr&& other) noexcept;
  StreamingQr& operator=(const StreamingQr& other);
  StreamingQr& operator=(StreamingQr&& other) noexcept;
  ~StreamingQr() = default;

  /// Adds rows.
  ///
  /// @param W  (rows × columns)
  /// @param Y  (rows × carried)
  /// @throws InputError where the sizes do not fit, or where an entry is not finite or above `largest`: the
  ///                    message
  ///         names its row and column. Nothing has been added then.
  void add(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Matrix>& Y);

  /// Room for the next rows, column after column those of W, then the carried ones: who makes rows writes
  /// them here instead of handing them to add(). It holds until anything else is called. Where fewer rows
  /// than wanted are free, those that wait are eliminated first.
  ///
  /// @param wanted  rows that must fit, at most `most_rows`
  /// @throws InputError  for more
  [[nodiscard]] RowsRoom room(Index wanted = 1);

  /// Adds the first rows of the room. Their entries are not looked at: finite() says whether they could be
  /// used.
  ///
  /// @throws InputError  for more rows than fit
  void commit(Index rows);

  /// Whether all entries so far were finite, and norms and sums of columns are at most `largest`.
  [[nodiscard]] bool finite() const;

  /// Adds all rows that another accumulator of the same columns has seen.
  ///
  /// @throws InputError where the numbers of columns differ
  void merge(const StreamingQr& other);

  [[nodiscard]] Index columns() const { return columns_; }
  [[nodiscard]] Index carried() const { return carried_; }
  [[nodiscard]] Index rows() const { return rows_; }

  /// R of W = Q R, upper triangular, (columns × columns). The signs of its rows are arbitrary.
  [[nodiscard]] Eigen::Block<const Matrix> R() const {
    return settled().triangle.topLeftCorner(columns_, columns_);
  }
  /// Qᵀ times the carried columns, (columns × carried).
  [[nodiscard]] Eigen::Block<const Matrix> qt_carried() const {
    return settled().triangle.block(0, columns_, columns_, carried_);
  }
  /// Qᵀ Y, (columns).
  [[nodiscard]] Vector qty() const { return qt_carried().col(carried_ - 1); }
  /// Norm of the part of Y that no combination of the columns of W reaches.
  [[nodiscard]] double unreachable_norm() const { return unreachable_norms()[carried_ - 1]; }
  /// The same for every carried column, (carried).
  [[nodiscard]] const Vector& unreachable_norms() const { return settled().unreachable; }

  /// 1ᵀ W, (columns).
  [[nodiscard]] Eigen::VectorBlock<const Vector> column_sums() const { return settled().sums.head(columns_); }
  [[nodiscard]] double y_sum() const { return settled().sums[columns_ + carried_ - 1]; }  ///< 1ᵀ Y
  [[nodiscard]] double y_norm() const;                                                    ///< ‖Y‖

  /// ‖Y − W chi‖, without another look at the rows.
  ///
  /// @throws InputError  where chi has another size than (columns); of residual_sum(), too
  [[nodiscard]] double residual_norm(const Eigen::Ref<const Vector>& chi) const;
  /// 1ᵀ (Y − W chi): the sum of the residual.
  [[nodiscard]] double residual_sum(const Eigen::Ref<const Vector>& chi) const;

 private:
  friend struct detail::StreamingQrFile;

  struct Free {
    void operator()(double* p) const { ::operator delete(p, std::align_val_t{64}); }
  };
  // What is known of the rows, and the rows that wait for their elimination.
  struct State {
    Matrix triangle;     // [R | Qᵀ carried] and zero rows up to the height that the kernel wants
    Vector unreachable;  // (carried)
    Vector sums;         // (columns + carried)
    std::unique_ptr<double[], Free> waiting;
    Index waiting_rows = 0;
  };

  [[nodiscard]] const State& settled() const;
  [[nodiscard]] State copied() const;
  void eliminate() const;
  void provide();
  void require_parameters(const char* who, Index count) const;
  void refuse(const Eigen::Ref<const Matrix>& W, const Eigen::Ref<const Matrix>& Y) const;

  Index columns_;
  Index carried_;
  Index rows_ = 0;
  // A reader eliminates the rows that wait. That is no change anyone could see, and the lock keeps it safe
  // for readers in several threads, as const promises.
  mutable std::mutex mutex_;
  mutable State state_;
};

/// An accumulator as the content of a file, so that rows reduced in one place can be merged in another. Every
/// number comes back bit for bit. All values are little-endian, whatever the machine:
///
/// | bytes | what |
/// |---|---|
/// | 8 | `rivid-QR` |
/// | 4, 4 | version of the format, 1; the number 0x01020304, which shows the order of the bytes |
/// | 8, 8, 8 | columns, carried columns, rows |
/// | 8 each | R and Qᵀ times the carried columns: column by column, each to the diagonal or the last row |
/// | 8 each | norms of the unreachable parts of the carried columns; sums of all columns |
/// | 8 | FNV-1a checksum of all bytes before it |
[[nodiscard]] std::string encoded(const StreamingQr& qr);

/// The accumulator that encoded() wrote.
///
/// @param source  a name for messages, such as the path of the file
/// @throws InputError where the content is none of that: another kind of file, another version, truncated,
///                    damaged
[[nodiscard]] StreamingQr decoded_streaming_qr(std::string_view content, std::string_view source);

/// The accumulator in a file.
///
/// @throws InputError where the file can not be read, and as decoded_streaming_qr() does
[[nodiscard]] StreamingQr read_streaming_qr(const std::filesystem::path& path);

}  // namespace rivid
