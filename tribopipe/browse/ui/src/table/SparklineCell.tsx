import { useEffect, useState } from "react";

import type { Sparkline } from "../api";
import { useWatch } from "../shell/revision";
import { askSparkline, HEIGHT, polylines, WIDTH } from "./sparkline";

/** The wear curve of a run, or another signal, small and without axes. */
export function SparklineCell({ id }: { id: string }) {
  const { changes } = useWatch();
  const [curve, setCurve] = useState<Sparkline | null>(null);
  useEffect(() => {
    const abort = new AbortController();
    askSparkline(id, abort.signal).then(
      (answer) => abort.signal.aborted || setCurve(answer),
      () => abort.signal.aborted || setCurve(null),
    );
    return () => abort.abort();
  }, [id, changes]);
  const lines = curve ? polylines(curve) : [];
  return (
    <td className="sparkline">
      {curve && lines.length > 0 && (
        <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} width={WIDTH} height={HEIGHT} role="img" aria-label={curve.name}>
          <title>{curve.name}</title>
          {lines.map((points, place) => (
            <polyline key={place} points={points} />
          ))}
        </svg>
      )}
    </td>
  );
}
