#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace rivid {

namespace detail {

// What the compiler holds in vector registers, however wide the machine's are.
template <int Lanes>
struct Lane {
  using Values [[gnu::vector_size(8 * Lanes)]] = double;
  using Bits [[gnu::vector_size(8 * Lanes)]] = std::int64_t;
  // As it stands in a column of samples: aligned like a double, not like a register.
  using InMemory [[gnu::vector_size(8 * Lanes), gnu::aligned(8), gnu::may_alias]] = double;
};

}  // namespace detail

/// Several samples as one Scalar: the kernels that are templated on Scalar then work on all of them at once.
///
/// @tparam Lanes  number of samples, a power of two
/// @tparam Tag    distinguishes instantiations that are compiled for different instruction sets. A function
///                that two object files both instantiate is kept once by the linker, compiled for whichever
///                machine; with a tag of an unnamed namespace each file keeps its own.
template <int Lanes, typename Tag = void>
class BasicPack {
 public:
  using Values = typename detail::Lane<Lanes>::Values;
  using Bits = typename detail::Lane<Lanes>::Bits;
  static constexpr int lanes = Lanes;

  /// Outcome of a comparison: all bits set in the lanes where it holds.
  struct Mask {
    Bits bits;
  };

  BasicPack() = default;
  // Written out, so that structs of packs are copied pack by pack: as a block of memory, g++ moves them
  // through integer registers, half a vector at a time.
  [[gnu::always_inline]] BasicPack(const BasicPack& other) : values_(other.values_) {}
  [[gnu::always_inline]] BasicPack& operator=(const BasicPack& other) {
    values_ = other.values_;
    return *this;
  }
  ~BasicPack() = default;
  /// The same value in all lanes. (Minus zero, not plus: that alone the compiler may leave out.)
  [[gnu::always_inline]] BasicPack(double value) : values_(value - Values{}) {}
  [[gnu::always_inline]] explicit BasicPack(const Values& values) : values_(values) {}

  /// From and to consecutive doubles of any alignment.
  [[gnu::always_inline]] static BasicPack load(const double* from) {
    // A copy: the constructor's reference would be one to memory that is not aligned.
    const Values values = *reinterpret_cast<const InMemory*>(from);
    return BasicPack(values);
  }
  [[gnu::always_inline]] void store(double* to) const { *reinterpret_cast<InMemory*>(to) = values_; }

  [[gnu::always_inline]] double operator[](int lane) const { return values_[lane]; }
  [[nodiscard, gnu::always_inline]] const Values& values() const { return values_; }

  [[gnu::always_inline]] friend BasicPack operator+(const BasicPack& a, const BasicPack& b) {
    return BasicPack(a.values_ + b.values_);
  }
  [[gnu::always_inline]] friend BasicPack operator-(const BasicPack& a, const BasicPack& b) {
    return BasicPack(a.values_ - b.values_);
  }
  [[gnu::always_inline]] friend BasicPack operator*(const BasicPack& a, const BasicPack& b) {
    return BasicPack(a.values_ * b.values_);
  }
  [[gnu::always_inline]] friend BasicPack operator/(const BasicPack& a, const BasicPack& b) {
    return BasicPack(a.values_ / b.values_);
  }
  [[gnu::always_inline]] friend BasicPack operator-(const BasicPack& a) { return BasicPack(-a.values_); }

  [[gnu::always_inline]] friend Mask operator>(const BasicPack& a, const BasicPack& b) {
    return {a.values_ > b.values_};
  }
  [[gnu::always_inline]] friend Mask operator<(const BasicPack& a, const BasicPack& b) {
    return {a.values_ < b.values_};
  }
  /// Lane by lane: a where the condition holds, else b.
  [[gnu::always_inline]] friend BasicPack select(const Mask& condition, const BasicPack& a,
                                                 const BasicPack& b) {
    return from_bits((condition.bits & a.bits().bits) | (~condition.bits & b.bits().bits));
  }

  /// Whether it holds in any lane.
  [[gnu::always_inline]] friend bool any(const Mask& condition) {
    std::int64_t all = 0;
    for (int lane = 0; lane < Lanes; ++lane) {
      all |= condition.bits[lane];
    }
    return all != 0;
  }
  /// Whether it holds in all lanes.
  [[gnu::always_inline]] friend bool all(const Mask& condition) { return !any(Mask{~condition.bits}); }
  [[gnu::always_inline]] friend Mask operator&(const Mask& a, const Mask& b) { return {a.bits & b.bits}; }
  [[gnu::always_inline]] friend Mask operator|(const Mask& a, const Mask& b) { return {a.bits | b.bits}; }

  /// Lanes that are too large for sin_cos_near().
  [[gnu::always_inline]] friend Mask too_far(const BasicPack& q) {
    return (q > BasicPack(largest_angle)) | (q < BasicPack(-largest_angle));
  }

  /// sin and cos of every lane: within 1.5 units in the last place up to 100 rad, 2.5 up to 1e5 rad. Lanes
  /// beyond are left to std::sin and std::cos, one after the other.
  [[gnu::always_inline]] friend void sin_cos(const BasicPack& q, BasicPack& s, BasicPack& c) {
    sin_cos_near(q, s, c);
    if (any(too_far(q))) [[unlikely]] {
      sin_cos_far(q, s, c);
    }
  }
  /// The same for lanes up to 1e5 rad alone.
  [[gnu::always_inline]] friend void sin_cos_near(const BasicPack& q, BasicPack& s, BasicPack& c) {
    sin_cos_reduced(q, s, c);
  }
  /// Replaces the lanes beyond 1e5 rad.
  [[gnu::always_inline]] friend void sin_cos_far(const BasicPack& q, BasicPack& s, BasicPack& c) {
    // By way of memory of its own, so that s and c may stay in registers.
    double angles[std::size_t{Lanes}];
    double sines[std::size_t{Lanes}];
    double cosines[std::size_t{Lanes}];
    q.store(angles);
    s.store(sines);
    c.store(cosines);
    for (int lane = 0; lane < Lanes; ++lane) {
      if (angles[lane] > largest_angle || angles[lane] < -largest_angle) {
        sines[lane] = std::sin(angles[lane]);
        cosines[lane] = std::cos(angles[lane]);
      }
    }
    s = load(sines);
    c = load(cosines);
  }
  [[gnu::always_inline]] friend BasicPack sin(const BasicPack& q) {
    BasicPack s;
    BasicPack c;
    sin_cos(q, s, c);
    return s;
  }
  [[gnu::always_inline]] friend BasicPack cos(const BasicPack& q) {
    BasicPack s;
    BasicPack c;
    sin_cos(q, s, c);
    return c;
  }
  /// Lane by lane.
  [[gnu::always_inline]] friend BasicPack tanh(const BasicPack& x) {
    double values[std::size_t{Lanes}];
    x.store(values);
    for (double& value : values) {
      value = std::tanh(value);
    }
    return load(values);
  }
  [[gnu::always_inline]] friend BasicPack exp(const BasicPack& x) {
    double values[std::size_t{Lanes}];
    x.store(values);
    for (double& value : values) {
      value = std::exp(value);
    }
    return load(values);
  }
  [[gnu::always_inline]] friend BasicPack sqrt(const BasicPack& x) {
    double values[std::size_t{Lanes}];
    x.store(values);
    for (double& value : values) {
      value = __builtin_sqrt(value);
    }
    return load(values);
  }

 private:
  using InMemory = typename detail::Lane<Lanes>::InMemory;
  static constexpr double largest_angle = 1e5;  // [rad] |k| < 2^16 below it; larger ones go one by one

  // Returned inside a struct: a bare vector as a result is a matter of ABI, of which the compiler warns.
  [[nodiscard, gnu::always_inline]] Mask bits() const { return {reinterpret_cast<Bits>(values_)}; }
  [[gnu::always_inline]] static BasicPack from_bits(const Bits& bits) {
    return BasicPack(reinterpret_cast<Values>(bits));
  }

  // q = k π/2 + r, |r| <= π/4, then the polynomials of FreeBSD's k_sin.c and k_cos.c in r.
  [[gnu::always_inline]] static void sin_cos_reduced(const BasicPack& q, BasicPack& s, BasicPack& c) {
    // Adding 1.5 · 2^52 rounds to the nearest whole number, which then stands in the lowest bits.
    const BasicPack to_whole(6755399441055744.0);
    const BasicPack shifted = q * BasicPack(0x1.45f306dc9c883p-1) + to_whole;
    const BasicPack k = shifted - to_whole;
    // π/2 in three parts, the first two short enough that k times them is exact for |k| < 2^20.
    const BasicPack r = ((q - k * BasicPack(0x1.921fb544p+0)) - k * BasicPack(0x1.0b4611a6p-34)) -
                        k * BasicPack(0x1.3198a2e037073p-69);
    const BasicPack z = r * r;
    const BasicPack sine_series = BasicPack(-1.66666666666666324348e-01) +
                                  z * (BasicPack(8.33333333332248946124e-03) +
                                       z * (BasicPack(-1.98412698298579493134e-04) +
                                            z * (BasicPack(2.75573137070700676789e-06) +
                                                 z * (BasicPack(-2.50507602534068634195e-08) +
                                                      z * BasicPack(1.58969099521155010221e-10)))));
    const BasicPack cosine_series = BasicPack(4.16666666666666019037e-02) +
                                    z * (BasicPack(-1.38888888888741095749e-03) +
                                         z * (BasicPack(2.48015872894767294178e-05) +
                                              z * (BasicPack(-2.75573143513906633035e-07) +
                                                   z * (BasicPack(2.08757232129817482790e-09) +
                                                        z * BasicPack(-1.13596475577881948265e-11)))));
    const BasicPack sine = r + (r * z) * sine_series;
    const BasicPack cosine = BasicPack(1.0) + z * (BasicPack(-0.5) + z * cosine_series);
    const Bits quadrant = shifted.bits().bits;
    const Bits odd = -(quadrant & 1);  // all bits set where sine and cosine change places
    const Bits sine_sign = (quadrant & 2) << 62;
    const Bits cosine_sign = ((quadrant + 1) & 2) << 62;
    s = from_bits(((odd & cosine.bits().bits) | (~odd & sine.bits().bits)) ^ sine_sign);
    c = from_bits(((odd & sine.bits().bits) | (~odd & cosine.bits().bits)) ^ cosine_sign);
  }

  Values values_;
};

/// Eight samples as one Scalar: a register of AVX-512, two of AVX2, four of plain x86-64.
using Pack = BasicPack<8>;

namespace detail {

// How the kernels find a Scalar in memory: packs with a tag, those of the library's batches, as consecutive
// doubles, one sample each; any other as itself.
template <typename Scalar>
struct Stored {
  using Value = Scalar;
  static constexpr std::ptrdiff_t lanes = 1;  // of anything but a pack
  [[gnu::always_inline]] static Scalar load(const Scalar* from) { return *from; }
  [[gnu::always_inline]] static void store(const Scalar& x, Scalar* to) { *to = x; }
};
template <int Lanes, typename Tag>
  requires(!std::is_void_v<Tag>)
struct Stored<BasicPack<Lanes, Tag>> {
  using Value = double;
  static constexpr std::ptrdiff_t lanes = Lanes;
  [[gnu::always_inline]] static BasicPack<Lanes, Tag> load(const double* from) {
    return BasicPack<Lanes, Tag>::load(from);
  }
  [[gnu::always_inline]] static void store(const BasicPack<Lanes, Tag>& x, double* to) { x.store(to); }
};

// Number types that are worth a step for each case of rotation and offset: they cost their time to compile.
template <typename Scalar>
inline constexpr bool has_quick_steps = false;
template <int Lanes, typename Tag>
  requires(!std::is_void_v<Tag>)
inline constexpr bool has_quick_steps<BasicPack<Lanes, Tag>> = true;

}  // namespace detail

}  // namespace rivid
