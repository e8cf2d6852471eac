/** Entry point of the page. */

import "./language.ts";
import { StrictMode, lazy } from "react";
import { createRoot } from "react-dom/client";
import { App } from "./App.tsx";
import { store } from "./store.ts";
import "@xyflow/react/dist/style.css";
import "uplot/dist/uPlot.min.css";
import "./kit/tokens.css";
import "./kit/controls.css";
import "./style.css";

/** The page of all components, which needs no server. */
const Gallery = lazy(() => import("./kit/Gallery.tsx").then((found) => ({ default: found.Gallery })));
const isGallery = location.hash === "#components";

if (!isGallery) store.connect();
createRoot(document.getElementById("root")!).render(<StrictMode>{isGallery ? <Gallery /> : <App />}</StrictMode>);
