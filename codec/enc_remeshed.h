// From semi-regular parts to a file: the encoder behind the remesher.
#pragma once
#include <memory>

#include "codec/enc_input.h"
#include "codec/encoder.h"

namespace mvw {

/// How bases are laid: as they are, or remeshes adapted to bases of few bits (enc_adapt.h), or of some more.
struct BaseGrid {
    bool snapped = true;
    unsigned finer_bits = 0;
    friend bool operator==(const BaseGrid&, const BaseGrid&) = default;
};

/// Bytes of the shortest beginning that matters: 0.2 bits for each of the input's vertices, at least 1 KB.
double least_beginning(const EncoderInput& input);

/// A remesh adapted to its surface (enc_adapt.h) and coded, so that remeshes can be compared before one is written.
class Draft {
 public:
    /// Codes `remeshed` of `input`, which must outlive the draft. Errors as encode()'s. options.threads: at least 1.
    static Result<Draft> make(EncoderInput& input, RemeshResult remeshed, const EncodeOptions& options,
                              const BaseGrid& grid = {});
    ~Draft();
    Draft(Draft&&) noexcept;
    Draft& operator=(Draft&&) noexcept;

    /// Mean PSNR of the file's beginnings of 0.2 to 1.5 bits for each of the input's vertices, of small ones from 1 to
    /// 5 KB. Measured at each call.
    [[nodiscard]] double score() const;
    /// The same of beginnings that have at least `floor` bytes.
    [[nodiscard]] double score_from(double floor) const;
    /// Of the Base chunks.
    [[nodiscard]] double base_bytes() const;
    /// RMS error that remeshing left, fraction of the diagonal.
    [[nodiscard]] double remeshing_error() const;
    /// The grid for bases that measures best, of three; that of make() where another cannot be coded.
    [[nodiscard]] BaseGrid best_grid(unsigned threads) const;
    /// Codes it anew where the grid is another one.
    Result<void> lay_bases(const BaseGrid& grid, unsigned threads);
    /// Measures every error against the input, and writes the file. `out` comes with what is known of the input and
    /// gets the rest. options: those of make(), but for threads and progress.
    Result<void> finish(const EncodeOptions& options, Encoded& out);

 private:
    struct State;
    explicit Draft(std::unique_ptr<State> state);
    Result<void> paint(const EncodeOptions& options, Encoded& out);
    std::unique_ptr<State> state_;
};

}  // namespace mvw
