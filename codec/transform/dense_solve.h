// Solver of the small symmetric positive definite systems behind the lifting weights.
#pragma once
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

namespace mvw {

/// Replaces b by the solution of A x = b. A: n x n, symmetric positive definite, row by row, of which only the lower
/// triangle is read; destroyed (Cholesky).
inline void solve_positive_definite(std::vector<double>& A, std::vector<double>& b) {
    const std::size_t n = b.size();
    assert(A.size() == n * n);
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k <= i; ++k) {
            double sum = A[n * i + k];
            for (std::size_t m = 0; m < k; ++m) sum -= A[n * i + m] * A[n * k + m];
            A[n * i + k] = i == k ? std::sqrt(sum) : sum / A[n * k + k];
        }
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t m = 0; m < i; ++m) b[i] -= A[n * i + m] * b[m];
        b[i] /= A[n * i + i];
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t m = i + 1; m < n; ++m) b[i] -= A[n * m + i] * b[m];
        b[i] /= A[n * i + i];
    }
}

}  // namespace mvw
