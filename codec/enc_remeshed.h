// From semi-regular parts to a file: the encoder behind the remesher.
#pragma once
#include <memory>

#include "codec/enc_input.h"
#include "codec/encoder.h"

namespace mvw {

/// A remesh adapted to its surface (enc_adapt.h) and coded, so that remeshes can be compared before one is written.
class Draft {
 public:
    /// Codes `remeshed` of `input`, which must outlive the draft. Errors as encode()'s. options.threads: at least 1.
    static Result<Draft> make(EncoderInput& input, RemeshResult remeshed, const EncodeOptions& options);
    ~Draft();
    Draft(Draft&&) noexcept;
    Draft& operator=(Draft&&) noexcept;

    /// Mean PSNR of the file's beginnings of 0.2 to 3 bits for each of the input's vertices. Measured at the first
    /// call.
    double score();
    /// RMS error that remeshing left, fraction of the diagonal.
    [[nodiscard]] double remeshing_error() const;
    /// Snaps bases to the grid that measures best, or to none, measures every error against the input, and writes the
    /// file. `out` comes with what is known of the input and gets the rest. options: those of make(), but for
    /// threads and progress.
    Result<void> finish(const EncodeOptions& options, Encoded& out);

 private:
    struct State;
    explicit Draft(std::unique_ptr<State> state);
    Result<void> choose_base_grid(unsigned threads);
    std::unique_ptr<State> state_;
};

}  // namespace mvw
