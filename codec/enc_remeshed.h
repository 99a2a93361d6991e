// From semi-regular parts to a file: the encoder behind the remesher.
#pragma once
#include <memory>

#include "codec/encoder.h"

namespace mvw {

/// A remesh coded as well as choices by measurement make it, so that remeshes can be compared before one is written.
class Draft {
 public:
    /// Codes `remeshed` of `input`, which must outlive the draft, as `options` must. Bases of several precisions are
    /// tried (enc_snap.h). Errors as encode()'s.
    static Result<Draft> make(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options);
    ~Draft();
    Draft(Draft&&) noexcept;
    Draft& operator=(Draft&&) noexcept;

    /// Mean PSNR of the file's beginnings of 0.2 to 3 bits for each of the input's vertices; 0 where there was nothing
    /// to choose between.
    [[nodiscard]] double score() const;
    /// RMS error that remeshing left, fraction of the diagonal.
    [[nodiscard]] double remeshing_error() const;
    /// Measures every error against the input and writes the file. `out` comes with what is known of the input and gets
    /// the rest.
    Result<void> finish(Encoded& out);

 private:
    struct State;
    explicit Draft(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/// The draft of one remesh, finished.
Result<void> encode_remeshed(const Mesh& input, RemeshResult remeshed, const EncodeOptions& options, Encoded& out);

}  // namespace mvw
