/** Entry point of the page: what takes time is asked for at once, before the rest is read. */

import "./language.ts";
import { isGallery } from "./address.ts";
import { layouter } from "./layout.ts";
import { store } from "./store.ts";
import "@xyflow/react/dist/style.css";
import "uplot/dist/uPlot.min.css";
import "./kit/tokens.css";
import "./kit/controls.css";
import "./style.css";

if (!isGallery()) {
  store.connect();
  layouter();
}
void import("./main.tsx");
