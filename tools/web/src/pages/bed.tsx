export default function Bed() { return <h1>Bed</h1>; }
