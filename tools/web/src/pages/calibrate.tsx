export default function Calibrate() { return <h1>Calibrate</h1>; }
