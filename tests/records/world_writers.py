"""Small files in the formats of further networks, written from numbers; see record_writers."""

import numpy as np

from tests.records.record_writers import cosmos_text, fixed, pairs_text


def cwa_text(north, east, up, rate: int = 100, sequence: str = "Time U(+); N(+); E(+)") -> str:
    """CWA (Taiwan): samples in Gal, as the columns of the sequence have them."""
    named = {"N": np.asarray(north, float), "E": np.asarray(east, float), "U": np.asarray(up, float)}
    count = named["N"].size
    columns = [named[word[0]] for word in sequence.removeprefix("Time").split(";") for word in [word.strip()]]
    lines = [
        "#Earthquake Information",
        "#Origin Time(GMT+08): 2018/02/06-23:50:42",
        "#EpicenterLongitude(E): 121.69",
        "#EpicenterLatitude(N): 24.14",
        "#Depth(km): 10.0",
        "#Magnitude(Ml): 6.0",
        "",
        "#Station Information",
        "#StationCode: TST",
        "#StationName: Test",
        "#StationLongitude(E): 121.092",
        "#StationLatitude(N): 22.860",
        "#InstrumentKind: FBA",
        "#StartTime(GMT+08): 2018/02/06-23:50:29.000",
        f"#RecordLength(sec): {count / rate:g}",
        f"#SampleRate(Hz): {rate}",
        "#AmplitudeUnit:  gal. DCoffset(corr)",
        *(f"#AmplitudeMAX. {letter}: {named[letter].max():8.3f}~ {named[letter].min():8.3f}" for letter in "UNE"),
        f"#DataSequence: {sequence}",
        "#Data: 4F10.3 ",
    ]
    rows = np.column_stack([np.arange(count) / rate, *columns])
    return "\n".join(lines) + "\n" + "".join("".join(f"{v:10.3f}" for v in row) + "\n" for row in rows)


def nsmn_text(north, east, up, interval: float = 0.01) -> str:
    """NSMN (Türkiye): samples in Gal."""
    columns = [np.asarray(x, float) for x in (north, east, up)]
    peaks = " ".join(f"({a}) {np.abs(x).max():.6f}" for a, x in zip(("N-S", "E-W", "U-D"), columns, strict=True))
    lines = [
        "STRONG GROUND MOTION RECORDS OF TURKIYE",
        "PLACE\t:\tTEST MERKEZ",
        "EARTHQUAKE DATE\t:\t17/08/1999 00:01:39.07 (GMT)",
        "EPICENTER COORDINATES\t:\t40.70000N-29.98700E",
        "EARTHQUAKE DEPTH (km)\t:\t15.9",
        "EARTHQUAKE MAGNITUDE\t:\t7.4(Ms)",
        "STATION ID\t:\t8101",
        "STATION COORDINATES\t:\t40.84370N-31.14888E",
        "STATION ALTITUDE(m)\t:\t",
        "RECORDER TYPE\t:\tSM-2",
        "RECORDER SERIAL NO\t:\t12",
        "RECORD TIME\t:\t17/08/1999 00:01:47.500000 (GMT)",
        f"NUMBER OF DATA\t:\t{columns[0].size}",
        f"SAMPLING INTERVAL (sec)\t:\t{interval:.6f}",
        f"RAW PGA VALUES (gal)\t:\t{peaks}",
        "PROCESSING\t:\tnone",
        "",
        "       N-S          E-W          U-D",
    ]
    rows = zip(*columns, strict=True)
    return "\n".join(lines) + "\n" + "".join("".join(f"{v:13.6f}" for v in row) + "\n" for row in rows)


def bhrc_text(components: dict, rate: float = 200.0, azimuths: tuple[int, int] = (324, 54)) -> str:
    """BHRC (Iran): ``components`` maps L, V and T to samples in g/10."""
    text = ""
    for number, (axis, samples) in enumerate(components.items(), 1):
        samples = np.asarray(samples, float)
        lines = [
            "* VOL1DS FILE:  5522/01",
            "Inst Type = SSA-2",
            "Origin Time : 2012/08/11   12:23:16",
            "",
            axis,
            "",
            f"COMP {axis}{number}",
            f"Test Shir                 Station   37.485 N 45.891 E   Altitude 1333m   Azimuth L {azimuths[0]}   T "
            f"{azimuths[1]} ",
            "Epicenter 38.520 N 46.860 E   FD 12 Km mb      Ms      Mw6.1   M        ML   (BHRC   )",
            "INSTR PERIOD =  .019 SEC   DAMPING =  .640",
            f"NO. OF POINTS ={samples.size:7d}      DURATION ={samples.size / rate:8.3f}",
            "UNITS ARE SECONDS AND G/10",
            "",
        ]
        whole = [0] * 88
        whole[25] = samples.size
        real = [0.0193424, 0.64, samples.size / rate, 0.0, 0.1, rate, *[0.0] * 26]
        text += "\n".join(lines) + "\n" + fixed(whole, 5, 0, 14)
        reals = [f"{v:13.6E}" for v in [*real[:5], *real[5:]]]
        text += "".join("".join(reals[i : i + 5]) + "   .00\n" for i in range(0, 30, 5)) + "".join(reals[30:32]) + "\n"
        text += fixed(samples, 13, 6, 10, form="E") + "/&\n"
    return text


def unam_text(channels: dict, interval: float = 0.01, first: str = "07:19:20.50") -> str:
    """UNAM's ASA 2.0: ``channels`` maps axis (N00E, V, N90W) to samples in Gal."""
    columns = [np.asarray(x, float) for x in channels.values()]

    def listed(values) -> str:
        return "/" + "/".join(str(v) for v in values) + "/"

    lines = [
        "================================================================",
        "                    ARCHIVO ESTANDAR DE ACELERACION",
        "VERSION DEL FORMATO                      : 2.0",
        "DATOS DE LA ESTACION:",
        "NOMBRE DE LA ESTACION                    : PRUEBA",
        "CLAVE DE LA ESTACION                     : TEST",
        "COORDENADAS DE LA ESTACION               : 17.211 LAT. N",
        "                                         : 100.642 LONG. W",
        "ALTITUD (msnm)                           : 20",
        f"ORIENTACION C1-C6 (rumbo;orientacion)    : {listed(channels)}",
        f"INTERVALO DE MUESTREO, C1-C6 (s)         : {listed([interval] * len(columns))}",
        "FECHA DEL SISMO [GMT]                    : 1995/09/14",
        "HORA EPICENTRO (GMT)                     : 07:19:10.0",
        f"HORA DE LA PRIMERA MUESTRA (GMT)         : {first}",
        f"DURACION DEL REGISTRO (s), C1-C6         : {listed(round(x.size * interval, 3) for x in columns)}",
        f"NUM. TOTAL DE MUESTRAS, C1-C6            : {listed(x.size for x in columns)}",
        f"ACEL. MAX.(Gal), C1-C6                   : {listed(f'{x[np.abs(x).argmax()]:.2f}' for x in columns)}",
        "UNIDADES DE LOS DATOS                    : Gal (cm/s/s)",
        "COMENTARIOS:",
        "DATOS DE ACELERACION:",
        "----------------------------------------------------------------",
        "    CANAL-1     CANAL-2     CANAL-3",
        "----------------------------------------------------------------",
    ]
    rows = zip(*columns, strict=True)
    return "\n".join(lines) + "\n" + "".join("".join(f"{v:12.2f}" for v in row) + "\n" for row in rows)


def renadic_text(channels: dict, interval: float = 0.005, trigger: str = "2/27/2010 6:34:50.000") -> str:
    """RENADIC (Chile): ``channels`` maps L, T and V to samples in g/10."""

    def lines(number: int, axis: str, size: int, peak: float) -> list[str]:
        return [
            "UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 06/30/2011",
            "0911131",
            "02/27/2010 6:34:00 (GMT)                (ORIGIN: 01/01/1980 0:00:00 GMT)",
            f"                                   TRIGGER TIME: {trigger} GMT",
            "STATION NO.          0.000N    0.000E  SMA-1     S/N  456 (3  CHNS OF 3  AT STA)",
            "PRUEBA S/N 4561",
            f"CHAN  {number}: {axis}        (STA CHN:  {number})",
            "UNIVERSIDAD DE CHILE - RENADIC",
            "HYPOCENTER:   0.000N    0.000E  H=   0.0KM   ML= 0.00",
            "INSTR PERIOD = 0.0400 SEC,  DAMPING =0.6000,  SENSITIVITY =1.000 VDC/G",
            f"NO. OF POINTS ={size:7d}  RECORD LENGTH ={size * interval:7.3f} SEC",
            f"UNITS OF UNCOR ACCEL ARE SEC AND G/10.     MAX  ={peak:7.4f} G, AT  11.895 SEC",
            "RMS ACCEL OF COMPLETE RECORD = 0.021 G",
        ]

    return pairs_text({axis: (0, samples) for axis, samples in channels.items()}, interval, lines)


def counts_text(a, b, *, microvolts=2000.0, volts_per_g=1.25, gain=2.0):
    """COSMOS volume 0: counts, with the recorder's step, the sensor's sensitivity and the gain among the reals."""
    text = cosmos_text({"340 deg": (340, a), "70 deg": (70, b)}, 0.01, unit=50, kind="Raw")
    lines = text.splitlines(keepends=True)
    for at in [i for i, line in enumerate(lines) if "Real-header" in line]:
        real = [float(line[k : k + 13]) for line in lines[at + 1 : at + 18] for k in range(0, len(line) - 1, 13)]
        real[21], real[41], real[46] = microvolts, volts_per_g, gain
        lines[at + 1 : at + 18] = fixed(real, 13, 6, 6).splitlines(keepends=True)
    return "".join(lines)


def usc_text(channels: dict, time=None, *, code: dict | None = None, narrow: bool = False) -> str:
    """USC volume 1: ``channels`` maps axis (N28W, UP) to samples in g/10, at times in s, by default 5 ms apart.

    ``code`` is what the integers have for an axis, ``narrow`` the variant with narrower integers and shorter lines.
    """
    codes = {"N28W": 332, "S62W": 242, "VERT": 400, "UP": 500, "DOWN": 600} | (code or {})
    per_line, width, pairs_per_line = (20, 4, 4) if narrow else (16, 5, 5)
    text = ""
    for axis, samples in channels.items():
        samples = np.asarray(samples, float)
        moments = np.arange(samples.size) * 0.005 if time is None else np.asarray(time, float)[: samples.size]
        lines = [
            "FILE     0 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:",
            f"{'TEST EARTHQUAKE':72}15",
            f"{'JAN 17, 1994 -1230 GMT':72}22",
            f"{'IBB999  94.999.0 N':72}18",
            f"{'STATION USC# 0099   34 25 09N, 118 25 34W':72}41",
            f"{'1 TEST RD., TESTING, CA':72}23",
            f"{f'COMP {axis}':72}{len(axis) + 5}",
            f"{'TEST EARTHQUAKE   JAN 17, 1994 -1230 GMT':72}40",
            f"{'EPICENTER -   34 12 48N, 118 32 13W':72}35",
            f"{'INSTR PERIOD =  .039 SEC  DAMPING =   .577  SENSITIVITY =   1.86CM/G':72}69",
            f"{f'NO. OF POINTS ={samples.size:7d}      DURATION ={moments[-1]:8.3f} SEC':72}50",
            f"{'UNITS ARE SEC AND G/10':72}22",
            f"{'RMS ACCLN. OF COMPLETE RECORD =     .638 G/10':72}45",
        ]
        whole, real = [0] * 100, [0.0] * 50
        whole[8:21] = 99, 34, 25, 9, 118, 25, 34, 34, 12, 48, 118, 32, 13
        whole[21:28] = 1, 17, 1994, 1230, 4, codes[axis], samples.size
        real[:12] = 0.039, 0.577, moments[-1], 0.638, 0.1, 1.86, 34.213, 118.537, 34.419, 118.426, 25.122, 6.7
        text += "\n".join(lines) + "\n" + fixed(whole, width, 0, per_line) + fixed(real, 10, 3, 8)
        data = fixed(np.column_stack([moments, samples]).ravel(), 7, 3, 2 * pairs_per_line)
        text += "".join(f" {line}\n" for line in data.splitlines()) + ("END OF CHANNEL\n" if len(channels) > 1 else "")
    return text
