// The draft that a file is written from: base, transform and grid are found by trials.
#pragma once
#include "codec/enc_remeshed.h"
#include "codec/remesh/remesh.h"

namespace mvw {

RemeshOptions remeshing_of(const EncodeOptions& options);

/// The draft that measures best. Trials of models of over 65,536 vertices at the finest, of three levels or more, have
/// one level less than the file shall have: that is a quarter of the cost, and beginnings of files, which the choice is
/// for, rarely reach the level that is left out.
///
/// Models remeshed by default, without parts that are not, of no more than 150,000 vertices (with parts of different
/// levels: 65,536 at the finest) are tried with three bases: the one where decimation stops, one 1.6 times larger
/// (sharp models) or smaller, and the next in the better direction. Where neither of the first two shows anything at
/// the least size that matters, but one less than 1.6 times smaller would, that is the third. Models of so few vertices
/// with sharp edges are tried without lifting, too, and are coded so unless that is worse: where parts are thinner than
/// base faces, what lifting adds to coarse levels overshoots. All remeshed models are tried with three grids.
/// options.threads: at least 1; any count gives the same draft. Errors as encode()'s.
Result<Draft> best_draft(EncoderInput& input, const EncodeOptions& options);

}  // namespace mvw
