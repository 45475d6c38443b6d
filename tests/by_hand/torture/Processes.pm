package Processes;

# The processes of a daemon: the front and what was forked for it.
use strict;
use warnings;
use Exporter 'import';
use FindBin;
use lib "$FindBin::Bin/../../support";
use Vt;

our @EXPORT = qw(family resident peak);

# [NAME, PID] of the daemon and all under it. One that ends meanwhile is none.
sub family {
    my ($daemon) = @_;
    my (%parent, %name);
    for my $pid (map {m{/(\d+)/}} glob '/proc/[0-9]*/stat') {
        my $stat = eval { Vt::slurp("/proc/$pid/stat") } // next;
        @name{$pid} = $stat =~ /\((.*)\)/s or next;
        ($parent{$pid}) = $stat =~ /\) \S (\d+)/;
    }
    my @pids = ($daemon->{pid});
    for (my $i = 0; $i < @pids; $i++) {
        push @pids, grep { $parent{$_} == $pids[$i] } keys %parent;
    }
    return map { [$name{$_}, $_] } grep { exists $name{$_} } @pids;
}

# Bytes in memory now, and at the most, of all processes of that name.
sub resident { return sum('smaps_rollup', 'Rss', @_) }
sub peak     { return sum('status', 'VmHWM', @_) }

sub sum {
    my ($file, $what, $daemon, $name) = @_;
    my $bytes = 0;
    for my $process (family($daemon)) {
        next unless $process->[0] eq $name;
        my $text = eval { Vt::slurp("/proc/$process->[1]/$file") } // next;
        $bytes += 1024 * $1 if $text =~ /^$what:\s+(\d+)/m;
    }
    return $bytes;
}

1;
