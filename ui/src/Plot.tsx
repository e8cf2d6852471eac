/** Numbers over time. */

import { useEffect, useRef } from "react";
import uPlot from "uplot";
import { store } from "./store.ts";

const MOST_CURVES = 8;

export function Plot({ channel, unit }: { channel: number; unit: string }) {
  const place = useRef<HTMLDivElement>(null);
  useEffect(() => {
    let plot: uPlot | undefined;
    let names = "";
    let frame = 0;
    const draw = () => {
      frame = requestAnimationFrame(draw);
      const track = store.tracks.get(channel);
      if (!track || !place.current) return;
      const curves = [...track.numbers].filter(([name]) => !/^tm\b/.test(name)).slice(0, MOST_CURVES);
      const now = curves.map(([name]) => name).join();
      const data = [track.times, ...curves.map(([, row]) => row)] as uPlot.AlignedData;
      if (!plot || now !== names) {
        plot?.destroy();
        names = now;
        const text = getComputedStyle(place.current).color;
        const axis = { stroke: text, grid: { stroke: "#8884", width: 1 }, ticks: { stroke: "#8884" } };
        plot = new uPlot(
          {
            width: place.current.clientWidth,
            height: 180,
            scales: { x: { time: false } },
            legend: { live: false },
            axes: [{ ...axis, label: "time [s]" }, unit ? { ...axis, label: unit } : axis],
            series: [{ label: "t" }, ...curves.map(([name], i) => ({ label: name, stroke: `hsl(${(i * 137) % 360} 70% 50%)` }))],
          },
          data,
          place.current,
        );
      } else if (plot.data[0].length !== track.times.length || plot.data[0].at(-1) !== plot.scales["x"]?.max) {
        plot.setData(data);
      }
    };
    draw();
    return () => {
      cancelAnimationFrame(frame);
      plot?.destroy();
    };
  }, [channel, unit]);
  return <div className="plot" ref={place} role="img" aria-label="Values over time" />;
}
