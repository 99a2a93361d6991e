// Which base, transform and grid a model is coded with: found by trials, drafts of one level less than the file shall
// have. They cost a quarter of what the file costs, and beginnings of files, which the choice is for, rarely reach the
// level that is left out.
#pragma once
#include "codec/enc_input.h"
#include "codec/enc_remeshed.h"
#include "codec/encoder.h"
#include "codec/remesh/remesh.h"

namespace mvw {

/// One way to make a file of a model.
struct Way {
    RemeshOptions remeshing;
    bool as_first = true;  // remeshed as at first
    TransformKind transform;
    BaseGrid grid;
};

RemeshOptions remeshing_of(const EncodeOptions& options);

/// The way that measures best. first: `input` remeshed by remeshing_of(options). Models of one part, remeshed by
/// default, of no more than 150,000 vertices, are tried with three bases: that of `first`, one 1.6 times larger (sharp
/// models) or smaller, and the next in the better direction, two trials at a time. Models of so few vertices with sharp
/// edges are tried without lifting, too, and are coded so unless that is worse: where parts are thinner than base
/// faces, what lifting adds to coarse levels overshoots. Any thread count gives the same.
Way choose_way(EncoderInput& input, const RemeshResult& first, const EncodeOptions& options);

}  // namespace mvw
