#!/usr/bin/perl
# How the binary is hardened, how exposed its unit is, and whether the image's files serve as another user, read-only and without
# capabilities.
use strict;
use warnings;
use File::Temp qw(tempdir);
use FindBin;
use lib "$FindBin::Bin/../../support";
use Getopt::Long;
use Vt;

my ($long, $seed) = (0, 1);
GetOptions('long' => \$long, 'seed=i' => \$seed) or exit 2;
$| = 1;
my $root = "$FindBin::Bin/../../..";
my $binary = $ENV{VORONOID} // "$root/build/release/voronoid";

sub row { my ($what, $figure, $wanted, $holds) = @_; print join("\t", 'G29', $what, $figure, $wanted, $holds ? 'ok' : 'short'), "\n" }

my $elf = `readelf --wide --file-header --program-headers --dynamic --dyn-syms $binary`;
my %has = (
    PIE => qr/^\s+Type:\s+DYN /m, RELRO => qr/^\s+GNU_RELRO /m, NOW => qr/\(FLAGS_1\).*\bNOW\b/, canary => qr/__stack_chk_fail/,
    FORTIFY => qr/__\w+_chk\b/, NX => qr/^\s+GNU_STACK .* RW /m,
);
my @missing = grep { $elf !~ $has{$_} } sort keys %has;
row('of ' . join(', ', sort keys %has) . ': missing', "@missing" || 'none', 'none', !@missing);

if (-x '/usr/bin/systemd-analyze') {
    my ($exposure) = `systemd-analyze security --no-pager --offline=true $root/docker/voronoid.service 2>&1` =~ /exposure level for \S+: ([\d.]+)/;
    row('systemd-analyze security of the unit', $exposure // 'none', '1.5 at most', defined $exposure && $exposure <= 1.5);
} else {
    print STDERR "no systemd-analyze here\n";
}

# The image's files, mounted read-only in a mount namespace of our own, with a state folder beside them.
if ($> != 0) {
    print STDERR "not root: the image's files are not tried\n";
    exit 0;
}
my $dir = tempdir(CLEANUP => 1);
chmod 0755, $dir;
system("cd $root && docker/rootfs.sh $binary $dir/root >/dev/null 2>&1") == 0 or die 'rootfs.sh failed';
system("mkdir -p $dir/state && chown 65532:65532 $dir/state");
my $script = <<"END";
mount --bind $dir/root $dir/root && mount --bind $dir/state $dir/root/var/lib/voronoid &&
mount -o remount,ro,bind $dir/root && mount -t tmpfs -o size=16m tmpfs $dir/root/tmp &&
exec setpriv --no-new-privs chroot --userspec=65532:65532 $dir/root \\
    /usr/bin/voronoid serve --listen 127.0.0.1:0 --data /var/lib/voronoid
END
my $pid = fork // die "fork: $!";
if (!$pid) {
    open STDERR, '>', "$dir/log";
    exec 'unshare', '-m', 'sh', '-c', $script or exit 127;
}
my $address = wait_until(sub { Vt::slurp("$dir/log") =~ /"address":"([^"]+)"/ ? $1 : '' }, 10);
if (!$address) {
    print STDERR 'the image\'s files do not serve here: ', Vt::slurp("$dir/log"), "\n";
    kill 'KILL', $pid;
    exit 1;
}
my %of = Vt::slurp("/proc/$pid/status") =~ /^(Uid|CapEff|CapPrm|NoNewPrivs):\s+(\S+)/mg;
row('user', $of{Uid}, 'not 0', $of{Uid} != 0);
row('capabilities', "$of{CapEff} $of{CapPrm}", 'none', "$of{CapEff}$of{CapPrm}" =~ /^0+$/);
row('no new privileges', $of{NoNewPrivs}, 1, $of{NoNewPrivs} == 1);
my ($flags) = map { (split ' ')[5] } grep { (split ' ')[4] eq '/' } split /\n/, Vt::slurp("/proc/$pid/mountinfo");
row('its root', $flags // 'unknown', 'ro', ($flags // '') =~ /\bro\b/);
my $answer = HTTP::Tiny->new(timeout => 30)->post("http://$address/v1/resample?points=200&format=ply", { content => sphere_ply(1000) });
row('and it resamples so', $answer->{status}, 200, $answer->{status} == 200);
kill 'TERM', $pid;
row('exit status', Vt::reap($pid), 0, 1);
