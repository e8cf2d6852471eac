/** What the page shows. */

import { StrictMode, lazy } from "react";
import { createRoot } from "react-dom/client";
import { App } from "./App.tsx";
import { isGallery } from "./address.ts";

/** The page of all components. */
const Gallery = lazy(() => import("./kit/Gallery.tsx").then((found) => ({ default: found.Gallery })));
createRoot(document.getElementById("root")!).render(<StrictMode>{isGallery() ? <Gallery /> : <App />}</StrictMode>);
