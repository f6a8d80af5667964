#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rivid/fields.hpp"
#include "rivid/regressor/base.hpp"
#include "rivid/regressor/regressor.hpp"
#include "rivid/types.hpp"

namespace rivid {

/// Instruction sets that batches are compiled for.
enum class Simd {
  best,      ///< the widest that this machine has
  baseline,  ///< what every x86-64 has; other processors know this one alone
  avx2,      ///< AVX2 and FMA
  avx512     ///< AVX-512F
};

template <>
inline constexpr std::array names_of<Simd> =
    std::to_array<std::string_view>({"best", "baseline", "avx2", "avx512"});

/// Whether this machine can run it.
[[nodiscard]] bool supported(Simd simd);

struct BatchOptions {
  int threads = 1;  ///< used by observation(); the result is the same, bit by bit, whatever their number
  /// Results of two sets differ by rounding, since some fuse multiplication and addition.
  Simd simd = Simd::best;

  [[nodiscard]] std::optional<std::string> complaint() const;
};

class BatchWorkspace;
class RegressorBlock;

namespace detail {
struct BatchKernel;
}

/// Rows of a regressor for many samples at once: several samples in the lanes of a vector register, by the
/// widest instruction set of the machine, which is chosen when the program runs.
///
/// A large W costs more to write to memory than to compute. Whoever can use it up piece by piece fills the
/// same RegressorBlock again and again, which stays in the cache:
///
///   const RegressorBatch batch(robot, base.columns());
///   RegressorBlock block(batch);
///   for (Index first = 0; first < motion.samples(); first += block.capacity()) {
///     batch.fill(motion, first, std::min(block.capacity(), motion.samples() - first), block);
///     // block.W(0), …, block.W(n − 1)
///   }
///
/// It is only read while it works: threads may share one, each with a block or a workspace of its own.
class RegressorBatch {
 public:
  /// @param parameters  columns of the regressor wanted, (b), each at most once; BaseParameters::columns()
  ///                    for W
  /// @throws InputError where a parameter occurs twice or is none of this robot, an option can not be used or
  ///                    the machine has not the instruction set asked for
  RegressorBatch(const Robot& robot, std::span<const StandardParameter> parameters,
                 const BatchOptions& options = {});

  [[nodiscard]] Index size() const { return columns_.size(); }
  [[nodiscard]] std::size_t joints() const { return columns_.joints(); }
  /// Columns that joint i's rows touch: indices into the parameters, ascending.
  [[nodiscard]] const std::vector<Index>& of_joint(std::size_t i) const { return columns_.of_joint(i); }
  /// The instruction set in use, never `best`.
  [[nodiscard]] Simd simd() const { return simd_; }

  /// Rows of samples first … first + count − 1, into rows 0 … count − 1 of the block. No allocation.
  ///
  /// @throws InputError where motion, first or count do not fit the robot or the block
  void fill(const Motion& motion, Index first, Index count, RegressorBlock& block) const;

  /// The same into memory of the caller's, from row `row` on. No allocation.
  ///
  /// @param targets  (n), each with room for rows row … row + count − 1 of its of_joint(i) columns
  void fill(const Motion& motion, Index first, Index count, std::span<const RowsTarget> targets, Index row,
            BatchWorkspace& workspace) const;

  /// What the kernels read, for who counts their arithmetic.
  [[nodiscard]] detail::RegressorPlan plan() const { return columns_.plan(); }

  /// @throws InputError in the name of `who`, where the motion is not one of this robot or lacks those
  ///                    samples
  void require(std::string_view who, const Motion& motion, Index first, Index count) const;

 private:
  friend class BatchWorkspace;

  void fill_entries(const detail::RegressorInput<double>& input, Index count,
                    BatchWorkspace& workspace) const;
  void fill_rest(const detail::RegressorInput<double>& input, Index rest, Index row,
                 BatchWorkspace& workspace) const;
  void fill_folded(const detail::RegressorInput<double>& input, Index count,
                   std::span<const RowsTarget> targets, Index row, BatchWorkspace& workspace) const;
  void fill_coupled(const Motion& motion, Index first, Index count, std::span<const RowsTarget> targets,
                    Index row, BatchWorkspace& workspace) const;

  RegressorColumns columns_;
  Simd simd_;
  const detail::BatchKernel* kernel_;
};

namespace detail {

// The set that `best` stands for on this machine.
[[nodiscard]] Simd resolved(Simd simd);

// throws InputError in the name of `who` where a value of the motion is not finite
void require_finite(std::string_view who, const Motion& motion);

struct AlignedDelete {
  void operator()(double* p) const;
};
// Doubles at a multiple of the longest vector, not initialised.
using AlignedDoubles = std::unique_ptr<double[], AlignedDelete>;
[[nodiscard]] AlignedDoubles aligned_doubles(std::size_t count);

}  // namespace detail

/// Scratch of RegressorBatch::fill(), made once and used for any number of samples by one thread.
class BatchWorkspace {
 public:
  explicit BatchWorkspace(const RegressorBatch& batch);

 private:
  friend class RegressorBatch;
  detail::AlignedDoubles scratch_;
  detail::AlignedDoubles tail_;   // input and output of samples that fill no whole pack
  std::vector<double*> columns_;  // where each entry's column begins
  std::vector<double*> tail_columns_;
  std::vector<double> folded_;  // where joints depend on others: the motion of all links, and their entries
};

/// Rows of all joints for some samples, in memory that suits the caches.
class RegressorBlock {
 public:
  using Rows = Eigen::Map<const Matrix, Eigen::Unaligned, Eigen::OuterStride<>>;

  /// As many samples as a second-level cache holds beside other things, 256 at most.
  explicit RegressorBlock(const RegressorBatch& batch);
  /// @param capacity  samples that it can hold, at least 1
  RegressorBlock(const RegressorBatch& batch, Index capacity);

  [[nodiscard]] Index capacity() const { return capacity_; }
  /// Samples that it holds now.
  [[nodiscard]] Index rows() const { return rows_; }
  /// Rows of joint i, (rows() × of_joint(i).size()).
  [[nodiscard]] Rows W(std::size_t i) const;

 private:
  friend class RegressorBatch;
  Index capacity_;
  Index rows_ = 0;
  detail::AlignedDoubles memory_;
  std::vector<RowsTarget> targets_;
  std::vector<Index> widths_;
  BatchWorkspace workspace_;
};

/// The rows of one joint in the observation matrix: only the columns that this joint's torque can depend on.
struct JointRows {
  std::vector<Index> columns;  ///< indices into the base parameters, ascending
  Matrix W;                    ///< (rows × columns.size())
};

/// Observation matrix W_fm of Eqs. (10–12) of [RIV], grouped joint by joint, without its zero blocks.
struct Observation {
  Index columns = 0;              ///< b
  std::vector<JointRows> joints;  ///< (n), each with n_m rows

  /// W as the paper writes it, (Σ rows × b), zeros filled in.
  [[nodiscard]] Matrix dense() const;
};

/// W_fm(q, q̇, q̈) of Eq. (12): the base regressor sampled along a motion.
///
/// It holds all of W at once; RegressorBatch gives it block by block.
///
/// @param motion  (n_m × n)
/// @throws InputError where the base parameters are those of another robot; where the motion has another
///                    number of joints than the robot, or sizes that differ; where an option can not be used
[[nodiscard]] Observation observation(const Robot& robot, const BaseParameters& base, const Motion& motion,
                                      const BatchOptions& options = {});

/// Base parameters that one motion can show: the same scan on IDM_st along the motion instead of at random
/// states. A joint that stands still, or an arm that moves in a plane, shows fewer parameters, and regroups
/// more of them, than the robot has; the names and the regrouping say which. Meant for judging an excitation,
/// and for models of robots that can move in no other way; a fit with the structural base parameters reports
/// the same as `rank_deficient`.
///
/// What counts is the independent part of a column relative to the largest column of the same unit: a
/// parameter is seen if a value of 1 moves the torques at least `tolerance` times as much as the best-seen
/// parameter of its unit.
///
/// The motion is used as it is. Filter it first and leave out its borders, as rows() does: noise is
/// independent of everything, and a joint's Coulomb column is ±1 for any velocity but zero.
///
/// Memory is that of one block of samples and a triangle of (N_s × N_s), however long the motion is.
///
/// @param motion     (n_m × n)
/// @param tolerance  between 0 and 1: about 1e-9 for a motion that is computed, 1e-3 to 1e-2 for a measured
///                   one
/// @throws InputError where the robot, the motion or the tolerance can not be used
[[nodiscard]] BaseParameters base_parameters(const Robot& robot, const Motion& motion, double tolerance);

}  // namespace rivid
