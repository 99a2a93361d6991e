// Numbers as people read them.

export function bytesText(bytes) {
  if (bytes < 1024) return `${Math.round(bytes)} B`;
  if (bytes < 1024 * 1024) return `${(bytes / 1024).toFixed(bytes < 10240 ? 1 : 0)} KB`;
  return `${(bytes / 1024 / 1024).toFixed(1)} MB`;
}

export function countText(count) {
  if (count < 10000) return String(count);
  if (count < 1e6) return `${(count / 1e3).toFixed(count < 1e5 ? 1 : 0)} k`;
  return `${(count / 1e6).toFixed(2)} M`;
}

/** An error as a fraction of the diagonal. */
export function errorText(error) {
  if (!(error > 0)) return 'none';
  const percent = error * 100;
  return `${percent < 0.001 ? percent.toExponential(1) : percent.toPrecision(2)} %`;
}
